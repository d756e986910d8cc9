"""Slack cable: trial stress ``s`` where positive, else nothing but a residual share [theory.md 2]."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from tautflex.elements.laws.law import LawFunction, TensionOnly, register_law
from tautflex.numeric import Array
from tautflex.structure.materials import Material


@LawFunction
def slack(stress: Array, tangent: Array, energy: Array, parameters: Array, count: int) -> None:
    """Stress, tangent and energy of cables; parameters: Young's modulus [Pa], residual share."""
    young, residual = parameters
    for e in range(count):
        trial = stress[0, e]
        factor = 1.0 if trial > 0.0 else residual
        energy[e] = 0.5 * factor * trial * trial / young
        stress[0, e] = factor * trial
        tangent[0, 0, e] = factor * young


@LawFunction
def slack_average(stress: Array, tangent: Array, energy: Array, parameters: Array, count: int) -> None:
    """`Law.average` of cables: taut on one stretch of the way, where the trial stress has its mean."""
    young, residual = parameters
    for e in range(count):
        start, end = stress[0, e], stress[1, e]
        low, high = min(start, end), max(start, end)
        taut = 1.0 if low >= 0.0 else max(high, 0.0) / (max(high, 0.0) - low)
        stress[0, e] = 0.5 * (residual * (start + end) + (1.0 - residual) * taut * (max(start, 0.0) + max(end, 0.0)))
        weight = taut * (2.0 - taut) if end > start else taut * taut
        tangent[0, 0, e] = young * (residual + (1.0 - residual) * weight)


@register_law
@dataclass(frozen=True)
class Slack(TensionOnly):
    """Cable that goes slack instead of carrying compression; option: `residual`."""

    name: ClassVar[str] = "slack"
    sections: ClassVar[tuple[str, ...]] = ("cable",)
    function: ClassVar[LawFunction | None] = slack
    average: ClassVar[LawFunction | None] = slack_average

    def parameters(self, material: Material) -> tuple[float, ...]:
        """Young's modulus [Pa] and residual share."""
        return material.youngs_modulus, self.residual
