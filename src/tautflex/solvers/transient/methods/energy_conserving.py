"""Energy-conserving method: mid-point rule with the average stress of the step."""

from __future__ import annotations

from dataclasses import dataclass

from tautflex.solvers.transient.methods.scheme import Combination, OneStageMethod, StepScheme


@dataclass(frozen=True)
class EnergyConserving(OneStageMethod):
    """Mid-point rule with internal forces ``G' V B(g_mid)' (sigma_0 + sigma_1)/2`` [theory.md 8].

    Notes
    -----
    Strains are quadratic in the displacements, so the internal forces do exactly the work that the strain energy takes
    up: without damping and load the total energy stays but for Newton's residual and round-off, at any step size and
    amplitude [Simo & Tarnow, Z. angew. Math. Phys. 43 (1992) 757]. Nonlinear laws keep it too: their average stress
    is the mean over the straight way between the strains of both ends [docs/integrators.md]. Damping takes out
    ``h v_mid' C v_mid`` per step, gyroscopic forces do no work.

    Linear momentum is conserved for every element that is free to move; angular momentum for Green-Lagrange films and
    cables, whose strains do not feel rotations, and not for von Karman strains or the frame's beams (small rotations).

    Second order; no numerical damping: high frequencies that the step does not resolve stay for ever. For linear
    elements it is the trapezoidal rule. The acceleration it keeps is that of the middle of the step and serves the
    first guess only.
    """

    @property
    def name(self) -> str:
        """Name in results."""
        return "energy-conserving"

    def scheme(self, step: float) -> StepScheme:
        """Coefficients for a step size [s]."""
        h = step
        # The unknown is half the increment: v_mid = 2 d / h, v_1 = 4 d / h - v_0, a = (v_1 - v_0) / h.
        middle = Combination(4.0 / h**2, -2.0 / h, 0.0)
        return StepScheme(
            evaluation=0.5,
            weight=1.0,
            inertia=middle,
            velocity=Combination(2.0 / h, 0.0, 0.0),
            end_displacement=Combination(2.0, 0.0, 0.0),
            end_velocity=Combination(4.0 / h, -1.0, 0.0),
            end_acceleration=middle,
            average_stress=True,
            tolerance=1e-12,
        )
