"""Rigid motion given as a table: angular velocity, attitude or acceleration of the frame over time."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError
from tautflex.motion.kinematics import Maneuver, RigidMotion, Segment, motion_about_point, unit_axis
from tautflex.motion.rotations import body_rates, continuous_quaternions
from tautflex.numeric import Array

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

ENDS = ("free", "rest")
_FINEST = 1e-12  # of the longest gap between rows: round-off takes shorter ones


@dataclass(frozen=True, eq=False, repr=False)
class Tabulated(Maneuver):
    """Motion through a table, interpolated by cubic splines with two continuous derivatives.

    Before the first and after the last row the frame coasts: constant angular velocity, and no acceleration of
    ``origin``. Velocity and acceleration come from the same spline, so that they belong together.

    Parameters
    ----------
    times
        Instants of the rows [s], rising from 0, shape (n,). An instant given twice splits the table: the angular
        acceleration (and ``accelerations``) may jump there, and integrators step onto it. Two rows alone are joined
        by a straight line, so that a table with every inner instant doubled is piecewise linear.
    rates
        Angular velocity about ``axis``, shape (n,), or its components in the floating frame, shape (n, 3) [rad/s].
    quaternions
        Attitude of the floating frame, scalar first, shape (n, 4): ``v_space = q v_frame q*``. Rows are normalised and
        their signs made to follow each other; the frame must turn by less than half a turn from row to row.
    accelerations
        Acceleration of ``origin`` along ``axis``, shape (n,), or in the axes of the floating frame, shape (n, 3)
        [m/s^2]; none if not given.
    ends
        ``"free"``: the spline of the quaternions leaves its first and last row as it comes; ``"rest"``: with no
        angular velocity, as a rest-to-rest maneuver does.
    axis
        Direction that one-column tables are about or along.
    origin
        Point of the floating frame that the frame turns about and that ``accelerations`` belong to [m].

    Raises
    ------
    InputError
        If the table is too short, disordered or inconsistent.

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.Tabulated(times=[0.0, 1.0, 2.0], rates=[0.0, 0.1, 0.0], axis=(1.0, 0.0, 0.0)).ends
    'free'
    """

    times: ArrayLike
    rates: ArrayLike | None = None
    quaternions: ArrayLike | None = field(default=None, kw_only=True)
    accelerations: ArrayLike | None = field(default=None, kw_only=True)
    ends: str = field(default="free", kw_only=True)
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        direction = unit_axis(self.axis)
        checks.vector3("origin", self.origin)
        checks.one_of("ends", self.ends, ENDS)
        times = _instants(self.times)
        tables: dict[str, Array | None] = {"times": times, "quaternions": None}
        for name in ("rates", "accelerations"):
            given = getattr(self, name)
            if given is not None and checks.numbers(name, given).ndim == 1:
                tables[name] = np.outer(_rows(name, given, len(times)), direction)
            else:
                tables[name] = None if given is None else _rows(name, given, len(times), 3)
        if self.quaternions is not None:
            tables["quaternions"] = continuous_quaternions(_rows("quaternions", self.quaternions, len(times), 4))
        _check_together(tables, self.ends)
        for name, table in tables.items():
            if table is not None:
                table.setflags(write=False)
            object.__setattr__(self, name, table)

    def __repr__(self) -> str:
        """Name the columns; a table of thousands of rows belongs in a file."""
        columns = [name for name in ("rates", "quaternions", "accelerations") if getattr(self, name) is not None]
        times = np.asarray(self.times)
        about = f"axis={self.axis}, origin={self.origin}, ends={self.ends!r}"
        return f"Tabulated({len(times)} rows of {' and '.join(columns)} from 0 to {times[-1]:g} s, {about})"

    @cached_property
    def _stretches(self) -> tuple[tuple[float, float, _SplineMotion], ...]:
        """Limits and motion between the instants that are given twice."""
        times = np.asarray(self.times)
        twice = np.flatnonzero(np.diff(times) == 0.0) + 1
        rows = [slice(first, last) for first, last in zip([0, *twice], [*twice, len(times)], strict=True)]
        return tuple((float(times[part][0]), float(times[part][-1]), self._motion_through(part)) for part in rows)

    def _motion_through(self, rows: slice) -> _SplineMotion:
        def spline(name: str) -> CubicSpline | None:
            table = getattr(self, name)
            if table is None:
                return None
            from scipy.interpolate import CubicSpline  # takes long to load, and few maneuvers are tables

            instants = np.asarray(self.times)[rows]
            if name == "quaternions" and self.ends == "rest":
                return CubicSpline(instants, table[rows], bc_type="clamped")
            return CubicSpline(instants, table[rows])

        origin = np.asarray(self.origin, dtype=float)
        return _SplineMotion(spline("rates"), spline("quaternions"), spline("accelerations"), origin)

    def _coast(self, motion: RigidMotion) -> RigidMotion:
        return motion_about_point(motion.angular_velocity, np.zeros(3), np.asarray(self.origin, dtype=float))

    def start(self) -> RigidMotion:
        """Coasting at the first angular velocity."""
        start, _, motion = self._stretches[0]
        return self._coast(motion(start))

    def segments(self) -> tuple[Segment, ...]:
        """One stretch of the table after the other, then coasting."""
        parts = tuple(Segment(*stretch) for stretch in self._stretches)
        coasting = self._coast(parts[-1].motion(parts[-1].end))
        return (*parts, Segment(parts[-1].end, np.inf, lambda time: coasting))


@dataclass(frozen=True)
class _SplineMotion:
    """Rigid motion at a time from the splines of a stretch of a table."""

    rates: CubicSpline | None
    quaternions: CubicSpline | None
    accelerations: CubicSpline | None
    origin: Array

    def __call__(self, time: float) -> RigidMotion:
        velocity, change = np.zeros(3), np.zeros(3)
        if self.rates is not None:
            velocity, change = self.rates(time), self.rates(time, 1)
        elif self.quaternions is not None:
            spline = self.quaternions
            velocity, change = body_rates(spline(time), spline(time, 1), spline(time, 2))
        push = np.zeros(3) if self.accelerations is None else self.accelerations(time)
        return motion_about_point(velocity, change, self.origin, push)


def _instants(times: ArrayLike) -> Array:
    values = np.array(checks.float_array("times", times, (None,)))
    if len(values) < 2:
        raise InputError(
            f"times: expected at least 2 instants, got {len(values)}; a table needs a beginning and an end"
        )
    if values[0] != 0.0:
        raise InputError(f"times: expected to begin at 0, got {values[0]:g} s; subtract it from all of them")
    checks.rising("times", values)
    lonely = np.flatnonzero((values[1:-1] == values[:-2]) & (values[1:-1] == values[2:]))
    if lonely.size or values[0] == values[1] or values[-1] == values[-2]:
        row = int(lonely[0]) + 1 if lonely.size else 0 if values[0] == values[1] else len(values) - 1
        raise InputError(
            f"times: expected an instant at most twice, and the first and last one once, got {values[row]:g} s; "
            "remove the surplus row"
        )
    gaps = np.diff(values)
    shortest, longest = float(gaps[gaps > 0.0].min()), float(gaps.max())
    if shortest < _FINEST * longest:
        raise InputError(
            f"times: expected gaps between rows that a spline can tell apart, got {shortest:g} s beside {longest:g} s; "
            "check the instants, or cut the table short"
        )
    return values


def _rows(name: str, given: ArrayLike, count: int, *columns: int) -> Array:
    values = np.array(checks.float_array(name, given, (None, *columns)))
    if len(values) != count:
        raise InputError(
            f"{name}: expected {count} rows, as many as times has, got {len(values)}; give one per instant"
        )
    return values


def _check_together(tables: dict[str, Array | None], ends: str) -> None:
    times, rates, quaternions = tables["times"], tables["rates"], tables["quaternions"]
    assert times is not None
    if rates is None and quaternions is None and tables["accelerations"] is None:
        raise InputError("rates: missing, a table expects rates, quaternions or accelerations; give one of them")
    if rates is not None and quaternions is not None:
        raise InputError("quaternions: expected no attitude beside rates, which say the same; remove one of the two")
    if ends == "rest" and quaternions is None:
        raise InputError("ends: expected 'free' without quaternions, got 'rest'; let the rates begin and end with 0")
    twice = np.flatnonzero(np.diff(times) == 0.0)
    if quaternions is not None and twice.size:
        raise InputError(
            f"times: expected each instant once with quaternions, got {times[twice[0]]:g} s twice; remove one"
        )
    if rates is not None:
        jumps = [row for row in twice if not np.allclose(rates[row], rates[row + 1], rtol=1e-12, atol=0.0)]
        if jumps:
            before, after = rates[jumps[0]].tolist(), rates[jumps[0] + 1].tolist()
            raise InputError(
                f"rates: expected the same angular velocity twice at {times[jumps[0]]:g} s, got {before} and {after}; "
                "only its slope may jump"
            )
