"""The one kernel (energy, force, tangent), the one inertia operator M(Z), and damping."""
