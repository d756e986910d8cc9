"""Transient response."""
