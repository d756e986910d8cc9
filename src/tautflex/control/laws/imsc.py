"""Independent modal space control."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex import checks
from tautflex.control.law import LawMatrices, LinearLaw, LinearMemory
from tautflex.control.riccati import require_columns
from tautflex.control.signals import LoopSpec
from tautflex.control.spillover import refuse_spillover
from tautflex.errors import InputError


@dataclass(frozen=True)
class IndependentModalControl(LinearLaw):
    """Independent modal space control: every mode has its own optimal regulator [Meirovitch & Baruh 1982].

    Modal filters (least squares) make coordinates of displacements and velocities, each mode's force
    ``f = -g eta - h deta/dt`` minimises ``integral w^2 eta^2 + (deta/dt)^2 + effort f^2``, so

        g = -w^2 + w sqrt(w^2 + 1/effort),    h^2 = 2 g + 1/effort,

    and the commands of least squares make the forces. The hub's motion must be prescribed.

    Parameters
    ----------
    displacement, velocity
        Names of the sensors: each tells at least as many numbers as modes are controlled.
    modes
        Number of the lowest modes that are controlled, >= 1; there must be as many commands.
    effort
        Weight of the modal forces [s^2], > 0: small makes the law strong.

    Raises
    ------
    InputError
        If a number is out of range; when a loop starts, if it has too few sensors or actuators.
    """

    displacement: str
    velocity: str
    modes: int = 1
    effort: float = 1.0
    follows_reference: ClassVar[bool] = False

    def __post_init__(self) -> None:
        checks.whole("modes", self.modes, 1)
        checks.positive("effort", self.effort)

    def start(self, spec: LoopSpec) -> LinearMemory:
        """No memory; modes that are not controlled must stay stable."""
        memory = super().start(spec)
        remedy = "control more modes with more sensors and actuators, or raise effort"
        refuse_spillover(spec, memory.matrices, type(self).__name__, "modes", remedy)
        return memory

    def matrices(self, spec: LoopSpec) -> LawMatrices:
        """One gain from measurements to commands."""
        plant, count = spec.plant(type(self).__name__), self.modes
        if plant.axes:
            raise InputError(
                f"hub: expected one whose motion is prescribed for {type(self).__name__}, got a free one, which joins "
                "the modes; take LQG"
            )
        if count > plant.coordinates:
            raise InputError(f"modes: expected at most {plant.coordinates}, those of the model, got {count}")
        require_columns(plant.truncated(count))
        first, half, eta = plant.positions[:count], plant.half, np.arange(count)
        w = np.sqrt(np.diag(plant.stiffness)[eta])
        g = -(w**2) + w * np.sqrt(w**2 + 1.0 / self.effort)
        h = np.sqrt(2.0 * g + 1.0 / self.effort)
        forces = np.zeros((count, len(plant.outputs)))
        places = checks.together(
            lambda: spec.measurement("displacement", self.displacement),
            lambda: spec.measurement("velocity", self.velocity),
        )
        parts = ("displacement", g, first), ("velocity", h, first + half)
        for place, (name, gain, columns) in zip(places, parts, strict=True):
            forces[:, place] -= gain[:, None] * _inverse(name, plant.C[np.ix_(place, columns)], "sensor points")
        command = _inverse("commands", plant.B[first + half].T, "actuators").T @ forces
        n = len(plant.outputs)
        law = np.concatenate([command, np.zeros((len(command), 3 * spec.axes))], axis=1)
        none = np.zeros((0, 0)), np.zeros((0, n + 3 * spec.axes)), np.zeros((len(command), 0))
        return LawMatrices.of(*none, law, plant.level)


def _inverse(name: str, matrix: np.ndarray, what: str) -> np.ndarray:
    """Least-squares inverse of a matrix with independent columns, one a mode."""
    if len(matrix) < matrix.shape[1] or np.linalg.cond(matrix) > 1e8:
        raise InputError(
            f"{name}: expected at least {matrix.shape[1]} {what} that tell the modes apart, got {len(matrix)} that do "
            "not; add some, move them off nodal lines, or control fewer modes"
        )
    return np.linalg.pinv(matrix)
