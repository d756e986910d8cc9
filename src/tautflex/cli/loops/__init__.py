"""Commands on a closed loop: what its inputs can do, and how it runs."""
