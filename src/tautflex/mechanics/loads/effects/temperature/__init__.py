"""Temperature of each kind of element: what strains freely, and what holds it back."""
