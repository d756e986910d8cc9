"""Spillover: what a linear law does to modes that it does not know [Balas 1978]."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tautflex.control.law import LawMatrices
from tautflex.control.linear import LinearPlant
from tautflex.control.signals import LoopSpec
from tautflex.errors import InputError
from tautflex.numeric import Array

# Growth per interval below this is that of an undamped mode, to round-off.
_LASTING = 1e-9
# Damping ratios below this are round-off; a mode that keeps less than this part of its own is told.
_DAMPED = 1e-9
_KEPT = 0.5


def loop_matrix(plant: LinearPlant, law: LawMatrices) -> Array:
    """Matrix of the loop of a discrete plant and a linear law on (x, last command, state of the law)."""
    (n, m), p = plant.B.shape, len(plant.outputs)
    look = np.concatenate([plant.C, plant.D, np.zeros((p, len(law.A)))], axis=1)
    command, own = law.D[:, :p] @ look, law.B[:, :p] @ look
    command[:, n + m :] += law.C
    own[:, n + m :] += law.A
    top = np.concatenate([plant.A, np.zeros((n, m + len(law.A)))], axis=1) + plant.B @ command
    return np.concatenate([top, command, own])


def refuse_spillover(spec: LoopSpec, law: LawMatrices, name: str, key: str, remedy: str) -> None:
    """Look at the loop of a law with all modes of a plant; those that it leaves hardly damped are remarks of the loop.

    Parameters
    ----------
    spec
        The loop.
    law
        Matrices of the law.
    name, key, remedy
        Its name, the argument that decides, and what to do.

    Raises
    ------
    InputError
        If the loop is unstable.
    """
    model = replace(spec, model=spec.beyond or spec.model).plant(name)
    plant = model.discretize(spec.interval)
    poles = np.linalg.eigvals(loop_matrix(plant, law))
    growth = float(np.abs(poles).max())
    if growth > 1.0 + _LASTING:
        highest = float(np.sqrt(np.abs(np.diag(plant.stiffness)).max(initial=0.0))) / (2.0 * np.pi)
        raise InputError(
            f"{key}: expected a law that leaves the modes beyond its own at rest, got {name} whose loop with all "
            f"{plant.coordinates} coordinates, up to {highest:.3g} Hz, grows {growth:.6g} times per interval "
            f"(spillover); {remedy}"
        )
    free = model.poles
    free = free[(free.imag > 0.0) & (-free.real > _DAMPED * np.abs(free))]
    own, now = np.exp(free * spec.interval), poles[np.abs(poles) > 0.0]
    if not len(own):
        return
    from scipy.optimize import linear_sum_assignment  # here, because the command line does without

    place, found = linear_sum_assignment(np.abs(own[:, None] - now))
    decay, left = -free[place].real, -np.log(np.abs(now[found])) / spec.interval
    worst = int(np.argmin(left / decay))
    if left[worst] < _KEPT * decay[worst]:
        size = abs(free[place[worst]])
        spec.remarks.append(
            f"{name} leaves the mode of {size / (2.0 * np.pi):.3g} Hz a damping ratio of "
            f"{100.0 * left[worst] / size:.2g} %, of {100.0 * decay[worst] / size:.2g} % without it (spillover); "
            f"{remedy}"
        )
