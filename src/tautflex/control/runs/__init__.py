"""Runs of plants: of the full structure, and of reduced models."""
