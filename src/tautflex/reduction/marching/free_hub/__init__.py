"""Reduced models on a free hub."""
