"""Links between nodes, one a file."""
