"""Reduced models: bases, exact polynomial forces, compiled time stepping."""
