"""Many steps in one compiled call."""
