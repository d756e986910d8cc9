"""What a batch leaves."""
