"""Reduced models with exact polynomial forces."""
