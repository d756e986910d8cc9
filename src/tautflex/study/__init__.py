"""Studies: from a case to a model, a run and its files."""
