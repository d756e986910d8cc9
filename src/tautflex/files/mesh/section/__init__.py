"""Sections of mesh files: what is stated, cross-sections by their dimensions, what is spread over elements."""
