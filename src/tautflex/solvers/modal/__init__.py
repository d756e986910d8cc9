"""Natural and spinning modes."""
