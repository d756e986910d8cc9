"""Every run of the reproduction as an ordinary case."""
