"""Arguments of `simulate`: checks, and their translation into steps and vectors."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tautflex import checks
from tautflex.errors import InputError
from tautflex.solvers.static.prestress import PrestressedState

Array = NDArray[np.float64]
# Beyond this the time axis alone would fill the memory.
_MOST_STEPS = 1e9
InitialVelocity = Callable[[Array, Array], ArrayLike] | ArrayLike | None


def step_count(time_step: float, end_time: float, every: int) -> int:
    """Steps of the grid that reaches ``end_time``."""
    step = checks.positive("time_step", time_step)
    if not checks.finite("end_time", end_time) >= step:
        raise InputError(f"end_time: expected at least one time_step ({step:g} s), got {end_time!r}")
    checks.whole("every", every, 1, remedy="1 stores every step")
    count = end_time / step
    if count > _MOST_STEPS:
        raise InputError(
            f"end_time: expected at most {_MOST_STEPS:g} steps, got {count:.3g}; run shorter or enlarge time_step"
        )
    return max(1, int(np.ceil(count - 1e-6)))


def check_parts(maneuver: object, method: object, coupling: object, damping: object, adaptive: object) -> None:
    """Raise InputError where an argument is not what its name says."""
    for name, value, needed, example in (
        ("maneuver", maneuver, "segments", "Stop(rate=0.628, duration=1.0)"),
        ("method", method, "scheme", "WilsonTheta()"),
        ("coupling", coupling, "velocity_weight", "Coupling()"),
        ("damping", damping, "matrix", "Rayleigh(0.001, 0.001)"),
    ):
        other = {"method": "stepper", "maneuver": "wrench"}.get(name, needed)
        if not (hasattr(value, needed) or hasattr(value, other)):
            raise InputError(f"{name}: expected an object such as {example}, got {value!r}")
    if adaptive is not None and not hasattr(adaptive, "limits"):
        raise InputError(f"adaptive: expected an object such as Adaptive(tolerance=1e-4), got {adaptive!r}")


def start_velocity(state: PrestressedState, given: InitialVelocity) -> Array:
    """Velocities of the free unknowns; rotations of beam nodes start at rest."""
    model = state.model
    if given is None:
        return np.zeros(state.system.size)
    if callable(given):
        x, y = model.nodes[:, 0], model.nodes[:, 1]
        values = np.zeros((len(model.nodes), 3))
        try:
            values[:, 2] = np.broadcast_to(np.asarray(given(x, y), dtype=float), x.shape)
        except (TypeError, ValueError) as error:
            raise InputError(
                f"initial_velocity: expected a function (x, y) -> velocity of shape {x.shape}, got {error}"
            ) from None
    else:
        values = np.asarray(given)
    values = checks.float_array("initial_velocity", values, (len(model.nodes), 3))
    full = np.zeros(model.dof_count)
    full[model.translation_dofs] = values
    return full[model.free_dofs]


def field_steps(fields: str | Sequence[float] | None, step: float, count: int, every: int) -> set[int]:
    """Steps of the grid whose whole field is stored."""
    if fields is None or isinstance(fields, str):
        checks.one_of("fields", fields or "none", ("none", "all"))
        return set(range(0, count + 1, every)) if fields == "all" else set()
    steps = set()
    for time in checks.float_array("fields", fields, (None,)):
        if not 0.0 <= time <= (count + 0.5) * step:
            raise InputError(f"fields: expected times in [0, {count * step:g}] s, got {time:g}")
        steps.add(round(time / step))
    return steps
