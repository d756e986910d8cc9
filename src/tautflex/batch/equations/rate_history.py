"""What drives a run, as functions of time and of numbers that may be traced: rotation about a line, or a free hub.

Maneuvers that are a formula bring it along (`tautflex.FixedAxis`): a step knows an instant inside its stretch, and the
formula masks what does not hold there. Tables are interpolated here, by matrices that multiply their rates.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from functools import singledispatch
from itertools import pairwise
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from scipy.interpolate import CubicSpline

from tautflex.batch.library import jax
from tautflex.errors import InputError, UnsupportedError
from tautflex.motion.fixed_axis import FixedAxis
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import AtRest, unit_axis
from tautflex.motion.tabulated import Tabulated

Array = jax.Array
Numbers = dict[str, Any]


class Spin(NamedTuple):
    """What drives a run at an instant; forces are linear in it.

    Parameters
    ----------
    rate, acceleration, square
        Angular rate [rad/s], acceleration and square of the rate [rad/s^2] about the axis.
    inputs
        Numbers of the inputs, shape (n,); (): there are none.
    torque
        On a free hub [N m]; (): the motion is prescribed, else ``rate`` is that at the start.
    """

    rate: Any
    acceleration: Any
    square: Any
    inputs: Any = ()
    torque: Any = ()


def spin_of(rate: Any, acceleration: Any) -> Spin:
    """Spin with the square that belongs to it."""
    return Spin(rate, acceleration, rate * rate)


@dataclass(frozen=True)
class RateHistory:
    """A maneuver whose numbers are arguments.

    Parameters
    ----------
    axis, origin
        Line that the frame turns about.
    numbers
        Numbers of the maneuver it was made from; any may be replaced.
    key
        What else tells this history from others.
    start
        Numbers -> angular rate before t = 0; None is rest.
    breaks
        Numbers -> instants where the motion may jump, any order, shape (k,).
    spin
        (numbers, time, an instant inside the stretch) -> motion; smooth in time within the stretch and beyond it.
    jumps
        Instants of everything else where forces may jump [s].
    hub
        The free hub, whose motion is part of the answer.
    """

    axis: tuple[float, float, float]
    origin: tuple[float, float, float]
    numbers: Numbers
    key: Hashable
    start: Callable[[Numbers], Any] | None
    breaks: Callable[[Numbers], Any]
    spin: Callable[[Numbers, Any, Any], Spin]
    jumps: tuple[float, ...] = ()
    hub: FreeHub | None = None

    def named(self, prefix: str) -> RateHistory:
        """The same with numbers whose names begin so."""
        start = self.start

        def own(numbers: Numbers) -> Numbers:
            return {name: numbers[prefix + name] for name in self.numbers}

        return replace(
            self,
            numbers={prefix + name: value for name, value in self.numbers.items()},
            start=None if start is None else lambda numbers: start(own(numbers)),
            breaks=lambda numbers: self.breaks(own(numbers)),
            spin=lambda numbers, time, inside: self.spin(own(numbers), time, inside),
        )

    def edges(self, numbers: Numbers) -> Any:
        """Instants that steps end on, in any order [s], shape (k,)."""
        return jnp.concatenate([self.breaks(numbers), jnp.asarray(self.jumps)])

    def end(self, numbers: Numbers) -> Any:
        """Last instant where the motion may jump [s]; 0 without any."""
        return jnp.max(self.breaks(numbers), initial=0.0)


def rate_history(maneuver: Any) -> RateHistory:
    """Rate history of a maneuver, or of a free hub; UnsupportedError for what has no batched form."""
    return _own_history(maneuver).named("hub." if isinstance(maneuver, FreeHub) else "maneuver.")


@singledispatch
def _own_history(maneuver: Any) -> RateHistory:
    raise UnsupportedError(
        f"maneuver: expected Stop, Slew, SpinUp or another FixedAxis, or Tabulated rates about one axis, got "
        f"{maneuver!r}; sample it: Tabulated(times, rates)"
    )


@_own_history.register
def _(maneuver: AtRest) -> RateHistory:
    nothing, axis = Spin(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)
    return RateHistory(axis, (0.0, 0.0, 0.0), {}, "rest", None, lambda _: jnp.zeros(0), lambda *_: nothing)


@_own_history.register
def _(maneuver: FreeHub) -> RateHistory:
    """Torque and spin at the start about the axis, and the hub's moment of inertia about it."""
    if maneuver.axes not in ("x", "y", "z"):
        raise UnsupportedError(
            f"maneuver: expected a hub that turns about one axis in a batch (axes = 'x', 'y' or 'z'), got axes = "
            f"{maneuver.axes!r}; simulate one by one"
        )
    if maneuver.feedback:
        raise UnsupportedError(
            "maneuver: expected a torque of three numbers on a hub in a batch, got a function; give 'hub.torque' per "
            "run, a table of forces on held nodes as inputs, or simulate one by one"
        )
    place = "xyz".index(maneuver.axes)
    line = np.eye(3)[place]
    offset = np.cross(line, maneuver.center)
    numbers = {
        "torque": float(maneuver.wrench()[3 + place]),
        "angular_velocity": float(maneuver.angular_velocity[place]),
        "inertia": float(maneuver.tensor[place, place] + maneuver.mass * offset @ offset),
    }

    def spin(numbers: Numbers, time: Any, inside: Any) -> Spin:
        return Spin(numbers["angular_velocity"], 0.0, 0.0, torque=numbers["torque"])

    def start(numbers: Numbers) -> Any:
        return numbers["angular_velocity"]

    return RateHistory(
        tuple(line.tolist()),
        (0.0, 0.0, 0.0),
        numbers,
        "hub",
        start,
        lambda _: jnp.zeros(0),
        spin,
        tuple(instant for instant in maneuver.breaks if instant > 0.0),
        maneuver,
    )


@_own_history.register
def _(maneuver: FixedAxis) -> RateHistory:
    """The maneuver's own formula, its numbers traced."""
    numbers = maneuver.numbers
    # What depends on no number is none of JAX's.
    before = maneuver.formula({name: jnp.asarray(value) for name, value in numbers.items()}).before
    rests = not isinstance(before, jax.Array) and before == 0.0

    def spin(numbers: Numbers, time: Any, inside: Any) -> Spin:
        return spin_of(*maneuver.formula(numbers).around(inside)(time))

    def breaks(numbers: Numbers) -> Any:
        limits = maneuver.formula(numbers).step.limits
        return jnp.stack([jnp.asarray(limit, dtype=float) for limit in limits])

    return RateHistory(
        maneuver.axis,
        maneuver.origin,
        numbers,
        (type(maneuver), *(value for name, value in vars(maneuver).items() if name not in numbers)),
        None if rests else lambda numbers: maneuver.formula(numbers).before,
        breaks,
        spin,
    )


@_own_history.register
def _(maneuver: Tabulated) -> RateHistory:
    """Cubic splines through rates are linear in the rates, so their matrices are computed once."""
    axis = unit_axis(maneuver.axis)
    rates = np.zeros((0, 3)) if maneuver.rates is None else np.asarray(maneuver.rates)
    along = rates @ axis
    if maneuver.quaternions is not None or maneuver.accelerations is not None or not len(rates):
        raise UnsupportedError("maneuver: expected a table of rates about one axis in a batch, got another table")
    if not np.allclose(rates, np.outer(along, axis), rtol=0.0, atol=1e-12 * float(np.abs(rates).max(initial=1.0))):
        raise InputError(f"maneuver: expected rates about axis = {maneuver.axis} alone, got rates about others too")
    times = np.asarray(maneuver.times)
    twice = np.flatnonzero(np.diff(times) == 0.0) + 1
    bounds = [0, *twice.tolist(), len(times)]
    starts: list[float] = []
    matrices, first, last, ends = [], [], [], []
    for begin, stop in pairwise(bounds):
        spline = CubicSpline(times[begin:stop], np.eye(len(times))[begin:stop])
        first.append(len(starts))
        starts += spline.x[:-1].tolist()
        matrices.append(spline.c)
        last.append(len(starts) - 1)
        ends.append(float(times[stop - 1]))
    coefficients = jnp.asarray(np.concatenate(matrices, axis=1))  # (power, interval, row)
    left, low, high, limits = (jnp.asarray(part) for part in (starts, first, last, ends))

    def spin(numbers: Numbers, time: Any, inside: Any) -> Spin:
        values = jnp.asarray(numbers["rates"])
        stretch = jnp.minimum(jnp.searchsorted(limits, inside, side="right"), len(ends) - 1)
        place = jnp.clip(jnp.searchsorted(left, time, side="right") - 1, low[stretch], high[stretch])
        c = coefficients[:, place] @ values
        s = time - left[place]
        over = inside >= limits[-1]
        rate = ((c[0] * s + c[1]) * s + c[2]) * s + c[3]
        slope = (3.0 * c[0] * s + 2.0 * c[1]) * s + c[2]
        return spin_of(jnp.where(over, values[-1], rate), jnp.where(over, 0.0, slope))

    return RateHistory(
        maneuver.axis,
        maneuver.origin,
        {"rates": along},
        ("tabulated", times.tobytes()),
        lambda numbers: jnp.asarray(numbers["rates"])[0],
        lambda numbers: limits,
        spin,
    )
