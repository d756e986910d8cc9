"""Time stepping on JAX."""
