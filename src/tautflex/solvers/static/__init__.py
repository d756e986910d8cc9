"""Prestress and static equilibrium."""
