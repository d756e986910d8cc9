"""What a run leaves: its record, how it ended, and what it cost."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from enum import Enum
from typing import TYPE_CHECKING

from tautflex.solvers.transient.restart.checkpoint import Checkpoint
from tautflex.text import card, count

if TYPE_CHECKING:
    import xarray as xr


class Status(Enum):
    """End of a run; ``message`` says what it means and what to try."""

    COMPLETED = "completed"
    NOT_CONVERGED = "not-converged"
    INTERRUPTED = "interrupted"

    @property
    def message(self) -> str:
        """The status in words, with the remedy."""
        return {
            Status.COMPLETED: "The run reached its end time.",
            Status.NOT_CONVERGED: "A step failed even at the smallest size (Newton's method, or the stability of an "
            "explicit method); the result is valid up to its last instant. Try a smaller time_step, more max_halvings, "
            "or a method with damping (generalized-alpha, rho_inf = 0.8).",
            Status.INTERRUPTED: "The run was interrupted; the result is valid up to its last instant.",
        }[self]


@dataclass
class Statistics:
    """Work done by a run.

    Parameters
    ----------
    steps
        Accepted steps, parts of halved ones included.
    iterations
        Newton steps.
    factorizations, back_substitutions
        Of the effective stiffness (and once of the mass matrix).
    force_evaluations
        Internal-force evaluations.
    halvings
        Times a step was halved because Newton failed or an explicit step was not stable.
    rejected
        Adaptive steps repeated with a smaller size because their error was too large.
    beyond_tolerance
        Adaptive steps kept although their error was too large, because ``min_step`` was reached.
    seconds
        Wall-clock time of the time stepping [s].
    """

    steps: int = 0
    iterations: int = 0
    factorizations: int = 0
    back_substitutions: int = 0
    force_evaluations: int = 0
    halvings: int = 0
    rejected: int = 0
    beyond_tolerance: int = 0
    seconds: float = 0.0

    def to_json(self) -> str:
        """All numbers as one JSON object."""
        return json.dumps(asdict(self))


@dataclass(frozen=True)
class Run:
    """Result of `tautflex.simulate`.

    Parameters
    ----------
    data
        Time histories at the probes, energies, stored fields and the mesh.
    status
        How the run ended.
    stats
        What it cost.
    reached
        Last instant that was reached [s].
    history
        Residual norms of the step that failed, newest last; empty if none did, or a reduced model's did.
    error
        Estimated time error of the displacements, relative to the largest one of the run, see
        :mod:`tautflex.solvers.transient.accuracy.time_error`; NaN where it was not asked for.
    energy_balance
        Energies at the start and the end and what came and went between [J], seen from inertial space: ``initial``,
        ``kinetic``, ``strain``, ``damping``, ``method``, ``loads``, ``maneuver`` and ``residual``, see
        :mod:`tautflex.solvers.transient.accuracy.energy`.
    final
        State at ``reached`` that another run goes on from, ``simulate(..., initial=run.final)``; None if there was no
        start.
    """

    data: xr.Dataset
    status: Status
    stats: Statistics
    reached: float
    history: tuple[float, ...] = ()
    error: float = float("nan")
    energy_balance: Mapping[str, float] = field(default_factory=dict)
    final: Checkpoint | None = None

    @property
    def warnings(self) -> list[str]:
        """What the user should know, in words."""
        return list(self.data.attrs["warnings"])

    def __repr__(self) -> str:
        data = self.data
        stored = f"{data.sizes['time']} instants, {count(data.sizes.get('field_time', 0), 'field')}"
        read = {
            f"probe {name}": f"largest |w| {float(abs(data['w'].sel(probe=name)).max()):.4g} m"
            for name in data["probe"].values
        }
        lines = {
            "status": f"{self.status.value}, reached {self.reached:.6g} s",
            "work": f"{count(self.stats.steps, 'step')}, {count(self.stats.iterations, 'iteration')}, "
            f"{count(self.stats.factorizations, 'factorization')}, {self.stats.seconds:.3g} s",
            "method": data.attrs.get("method"),
            "maneuver": data.attrs.get("maneuver"),
            "record": f"{stored}, {data.nbytes / 1e6:.3g} MB",
            **read,
            **{f"warning {number}": text for number, text in enumerate(data.attrs.get("warnings", ()), start=1)},
        }
        return card(self, lines)
