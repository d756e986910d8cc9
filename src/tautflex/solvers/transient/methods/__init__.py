"""Time integrators: one small file each."""
