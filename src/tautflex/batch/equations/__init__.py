"""Equations of motion on JAX."""
