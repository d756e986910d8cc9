"""Sections of a case file."""
