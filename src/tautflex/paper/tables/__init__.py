"""The paper's tables: printed numbers, ours, and how they compare."""
