"""Damping in proportion to mass and stiffness."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tautflex import checks
from tautflex.mechanics.dampings.damping import Damping, LinearStructure
from tautflex.mechanics.dampings.matrix import DampingMatrix
from tautflex.structure.kinds import ByKind, by_kind


@dataclass(frozen=True)
class Rayleigh(Damping):
    """Proportional damping ``C = alpha M + beta K(reference)`` [paper sec. 3], one number or one per kind of element.

    Parameters
    ----------
    alpha
        Mass factor [1/s], >= 0; or by kind of element, such as ``{"membrane": 0.1, "frame": 0.02}``, whose own mass
        it multiplies. A kind that is left out has 0.
    beta
        Stiffness factor [s], >= 0; K is the tangent of the prestressed reference state. Or by kind of element, such as
        ``{"membrane": 1e-3, "cable": 0.0, "frame": 1e-3}``: it multiplies the material stiffness of that kind, and the
        membrane's also the stiffness of the prestress of all. A kind that is left out has 0.

    Notes
    -----
    A mode of angular frequency w has the ratio ``alpha / (2 w) + beta w / 2`` [Clough & Penzien, Dynamics of
    Structures, 12-4]. By kind, ``C = sum_e (alpha_e M_e + beta_e K_e) + beta_membrane K_0``: materials have different
    loss factors, while K_0, which comes from the tensions, belongs to none.

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.Rayleigh(alpha=0.001, beta={"membrane": 0.001, "cable": 0.0}).alpha
    0.001
    """

    alpha: float | Mapping[str, float] = 0.0
    beta: float | Mapping[str, float] = 0.0

    def __post_init__(self) -> None:
        for name in ("alpha", "beta"):
            object.__setattr__(self, name, by_kind(name, getattr(self, name), checks.non_negative, 0.0))

    def matrix(self, structure: LinearStructure) -> DampingMatrix:
        """``alpha M + beta K``; by kind, what each has besides."""
        alpha: Any = self.alpha
        beta: Any = self.beta
        if not isinstance(alpha, ByKind) and not isinstance(beta, ByKind):
            return DampingMatrix(alpha, beta)
        own_alpha, own_beta = (part if isinstance(part, ByKind) else ByKind({}, part) for part in (alpha, beta))
        # Numbers for all stay factors of M and K; those of the mass by kind need no common one.
        mass, stiffness = 0.0 if isinstance(alpha, ByKind) else alpha, own_beta["membrane"]
        kinds = {kind: (own_alpha[kind] - mass, own_beta[kind] - stiffness) for kind in structure.system.kinds}
        return DampingMatrix(mass, stiffness, kinds=kinds)
