"""Ways to perform the points of a study; all give the same files."""
