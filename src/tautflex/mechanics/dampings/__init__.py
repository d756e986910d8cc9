"""Damping models: one small file each."""
