"""Sparse direct solution of symmetric systems."""
