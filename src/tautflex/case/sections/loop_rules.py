"""Rules that hold between the sections of a closed loop and the others."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from tautflex.case.messages import show
from tautflex.case.registry import METHODS

# Keys that a loop has no use for, as those of runs of one piece; all else is refused by their own classes.
_UNUSED = {
    "solver": ("tolerance", "max_halvings", "adaptive_tolerance", "initial_imperfection", "time_error"),
    "output": ("every", "fields", "probe_reading"),
    "coupling": ("gyroscopic", "euler", "centrifugal", "inertial_load"),
}


def loop_contradictions(case: Any) -> Iterator[str]:
    """What in a case contradicts its loop, each in one line."""
    for name, actuator in case.actuators.items():
        if actuator.kind == "hub-torque" and case.hub is None:
            text = f"actuators.{name}.kind: expected a [hub] section beside 'hub-torque', got none"
            yield f"{text}; add it with mass and inertia, or command the structure alone"
        if name in case.sensors:
            yield f"sensors.{name}: expected a name of its own, got that of an actuator; choose another one"
    if case.controller is None:
        return
    for section, names in _UNUSED.items():
        values = getattr(case, section)
        for name in names:
            value, default = getattr(values, name), type(values).model_fields[name].get_default()
            if value != default:
                text = "no value" if default is None else show(default)
                text = f"{section}.{name}: expected {text} beside a [controller], got {show(value)}"
                yield f"{text}; remove it, a loop runs and is stored interval by interval"
    if not issubclass(METHODS[case.solver.method], METHODS.bases[: 1 if case.reduction is None else 2]):
        text = f"solver.method: expected an implicit method beside a [controller], got {show(case.solver.method)}"
        yield f"{text}; take for example 'generalized-alpha'"
    step, interval = case.solver.time_step, case.loop.interval
    count = interval / step
    if round(count) < 1 or abs(count - round(count)) > 1e-6:
        text = f"loop.interval: expected a multiple of solver.time_step = {step:g} s, got {interval:g}"
        yield f"{text}; set for example interval = {max(1, round(count)) * step:.6g}"
