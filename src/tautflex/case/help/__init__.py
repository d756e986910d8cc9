"""What the classes and sections say about the keys of a case file."""
