"""Prescribed rigid motion of the floating frame."""
