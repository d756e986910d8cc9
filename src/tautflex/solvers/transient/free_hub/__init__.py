"""Structures on a free hub."""
