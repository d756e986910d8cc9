"""Linear, static, modal and transient solvers; one file per time integrator."""
