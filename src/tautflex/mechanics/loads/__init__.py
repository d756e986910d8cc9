"""What acts on the structure: one effect a file."""
