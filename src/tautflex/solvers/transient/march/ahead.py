"""What acts in the steps of a stretch beside the structure and its frame, evaluated before they are taken.

Forces in time need no state. The force and torque of a hub may be functions of time and of its motion: they are called
with a state of which the time alone is known, and whoever looks at the rest has steps that are the driver's.
"""

from __future__ import annotations

from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.mechanics.loads.inputs import earlier
from tautflex.mechanics.loads.prepared import PatternLoad
from tautflex.motion.hub import Actuation, FreeHub, HubState
from tautflex.numeric import Array, Indices
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.solvers.transient.free_hub.equation import HubEquation


class Ahead(NamedTuple):
    """Loads and wrenches of a stretch.

    Parameters
    ----------
    loads, outside
        Different loads of the inputs, and what of each pushes the spacecraft, shape (load, size).
    which
        The load of every instant, shape (instant,).
    wrenches
        Of a free hub those on the hub and on its supports, shape (instant, 6).
    """

    loads: Array
    outside: Array
    which: Indices
    wrenches: Array

    @property
    def known(self) -> int:
        """Number of instants whose wrench is known."""
        return len(self.wrenches)


class _TimeAlone(HubState):
    """Hub of which the time alone is known."""

    looked: ClassVar[bool] = False

    def __init__(self, time: float) -> None:
        object.__setattr__(self, "time", time)

    def __getattribute__(self, name: str) -> object:
        if name not in {"time", "__class__"}:
            object.__setattr__(self, "looked", True)
            raise AttributeError(f"{name} of the hub is not known yet")
        return object.__getattribute__(self, name)


class Outlook:
    """Evaluates what acts at instants ahead.

    Parameters
    ----------
    equation
        Equation of motion whose inputs are forces or stresses of fixed patterns.

    Attributes
    ----------
    follows_motion
        Whether a function of the hub has looked at more than the time.
    """

    def __init__(self, equation: EquationOfMotion) -> None:
        self._equation, self.follows_motion = equation, False
        self._values = dict[float, list[Array]]()

    def at(self, instants: Array, before: float) -> Ahead:
        """What acts at instants [s], a jump not met yet; wrenches as far as they are known."""
        equation, inputs, none = self._equation, self._equation.inputs, np.zeros((0, 6))
        self._values.clear()
        if isinstance(equation, HubEquation):
            return self._on_hub(equation, instants, before)
        loads, which, last = list[Array](), np.zeros(len(instants), dtype=np.int64), b""
        if not inputs:
            return Ahead(found := equation.at_rest.load[None], found, which, none)
        for number, instant in enumerate(instants.tolist()):
            values = self._at(instant, before)
            pairs = zip(inputs.linear, values, strict=True)
            key = b"".join(value.tobytes() for item, value in pairs if isinstance(item, PatternLoad))
            if key != last or not loads:
                last = key
                loads.append(inputs.load_of(values))
            which[number] = len(loads) - 1
        return Ahead(found := np.array(loads), found, which, none)

    def stresses(self, times: Array, instants: Array, before: float, sampled: Array) -> Any:
        """What `take_steps` reads of stresses that inputs change in time; None where none does.

        ``times`` are the ends of steps from their start on, ``instants`` as of `Sized.instants`, ``sampled`` where
        samples are taken.
        """
        equation, inputs = self._equation, self._equation.inputs
        if equation.pattern is None or not inputs:
            return None
        starts = instants[:, 1].copy()
        starts[1:] = instants[:-1, 1]
        starts[:: len(instants) // (len(times) - 1)] = times[:-1]
        wanted = [*np.column_stack([starts, instants]).ravel().tolist(), *sampled.tolist()]
        numbers = np.array([np.concatenate(self._at(instant, before)) for instant in wanted])
        if (numbers == numbers[0])[:, inputs.stressing].all():
            equation.set_time(float(times[0]))
            return None
        equation.forget_time()
        rows = 3 * len(instants)
        return tuple(equation.pattern), numbers[:rows].reshape(-1, 3, numbers.shape[1]), numbers[rows:]

    def _at(self, instant: float, before: float) -> list[Array]:
        """Numbers of the inputs at an instant [s] of this stretch."""
        assert self._equation.inputs
        if instant not in self._values:
            self._values[instant] = self._equation.inputs.each_value(earlier(instant, before))
        return self._values[instant]

    def _on_hub(self, equation: HubEquation, instants: Array, before: float) -> Ahead:
        """The same on a free hub."""
        times = np.minimum(instants, earlier(np.inf, before)).tolist()
        own = self._wrenches(equation.hub, times)
        loads, outside, added = [equation.input_load], [equation.outside], [equation.added_wrench]
        which = np.zeros(len(times), dtype=np.int64)
        if equation.inputs:
            loads, outside, added, then = [], [], [], np.nan
            for number, instant in enumerate(instants[: max(len(own), 1)].tolist()):
                changed = instant != then and equation.set_time(instant, before)
                if changed or not loads:
                    loads.append(equation.input_load)
                    outside.append(equation.outside)
                    added.append(equation.added_wrench)
                which[number], then = len(loads) - 1, instant
        wrenches = own + np.array(added)[which[: len(own)]]
        return Ahead(np.array(loads), np.array(outside), which, wrenches)

    def _wrenches(self, hub: FreeHub, times: list[float]) -> Array:
        """Wrenches on the hub itself, as far as the motion need not be known and no function fails, shape (n, 6)."""
        found = np.zeros((len(times), 6))
        for name, columns in (("force", slice(3)), ("torque", slice(3, 6))):
            given = getattr(hub, name)
            if callable(given):
                values = checks.vectors3(name, self._given(given, times))
                found, times = found[: len(values)], times[: len(values)]
            elif given is not None:
                values = checks.vector3(name, given)
            else:
                continue
            found[:, columns] = values
        return found

    def _given(self, function: Actuation, times: list[float]) -> list[ArrayLike]:
        """What a function of the hub gives, up to where it looks at more than the time or fails."""
        found, last = list[ArrayLike](), np.nan
        for time in times:
            if time == last:
                found.append(found[-1])
                continue
            state, last = _TimeAlone(time), time
            try:
                # Of a tuple nothing can change; anything else may be filled in anew by the next call.
                value = given if isinstance(given := function(time, state), tuple) else np.array(given)
            except Exception:  # the driver meets it where it is, with the motion
                value = None
            if object.__getattribute__(state, "looked"):
                self.follows_motion, value = True, None
            if value is None:
                break
            found.append(value)
        return found
