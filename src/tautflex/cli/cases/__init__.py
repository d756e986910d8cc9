"""Commands on a case: what it is and what its structure does."""
