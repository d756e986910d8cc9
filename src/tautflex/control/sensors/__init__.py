"""Sensors: one a file."""
