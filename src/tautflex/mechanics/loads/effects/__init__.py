"""What one unit of an input does to the structure: one effect a file."""
