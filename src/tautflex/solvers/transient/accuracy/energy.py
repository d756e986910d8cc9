r"""Energy balance of a run, seen from inertial space, from the books of its steps [theory.md 9, 13].

With the kinetic energy of absolute velocities split into that of the elastic motion alone, T, and what the frame
carries beside it, X (`carried_energy`), and the strain energy U above the reference,

    d(T + U)/dt = -dq' (C dq + frame forces - loads),        dX/dt = dq' frame forces + work of whatever moves the hub.

The books hold what inertia (I), internal forces (N), damping, frame (F) and loads of the steps' own equilibria do on
the elastic displacement. The method's share is what its inertia and internal forces did beside the energies that they
stand for, ``I - dT + N - dU``: numerical dissipation, with its sign. Prescribed motion does what changes X beside F,
and work of loads on that motion is its own. A free hub is moved by the wrench of all loads, and what X took up
otherwise is again the method's. The residual is what all these leave: the work of the steps' unbalanced forces.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import Maneuver, RigidMotion, Segment
from tautflex.numeric import Array, cross
from tautflex.solvers.transient.accuracy.books import DAMPING, FRAME, INERTIA, INTERNAL, LOAD, RIGID, STRESS
from tautflex.solvers.transient.equation import EquationOfMotion
from tautflex.solvers.transient.free_hub.equation import HubEquation
from tautflex.solvers.transient.free_hub.momentum import Body, carried_energy
from tautflex.solvers.transient.free_hub.motion import HubMotion
from tautflex.solvers.transient.state import MotionState

TERMS = ("initial", "kinetic", "strain", "damping", "method", "loads", "maneuver", "residual")


class Energies(NamedTuple):
    """Energies of one instant [J].

    Parameters
    ----------
    elastic
        Kinetic energy of the elastic motion alone.
    carried
        The rest of the kinetic energy in the inertial frame.
    strain
        Strain energy above the reference.
    """

    elastic: float
    carried: float
    strain: float


def energy_balance(first: Energies, last: Energies, work: Array, free: bool) -> dict[str, float]:
    """Balance of a run by the names in `TERMS` [J].

    Parameters
    ----------
    first, last
        At the start and at the end.
    work
        That of the `Books` at the end, shape (7,).
    free
        Whether the hub is free: then nothing prescribes its motion.

    Returns
    -------
    dict
        ``initial + loads + maneuver = kinetic + strain + damping + method + residual``; damping and method are what
        they took out.
    """
    gained = [after - before for before, after in zip(first, last, strict=True)]
    terms = {
        "initial": sum(first),
        "kinetic": last.elastic + last.carried,
        "strain": last.strain,
        "damping": work[DAMPING],
        "method": work[INERTIA] - gained[0] + work[INTERNAL] + work[STRESS] - gained[2],
        "loads": work[STRESS] - work[LOAD],
        "maneuver": 0.0,
    }
    if free:
        terms["method"] += work[FRAME] + work[RIGID] - gained[1]
        terms["loads"] += work[RIGID]
    else:
        terms["maneuver"] = gained[1] - work[FRAME]
    taken = sum(terms[name] for name in ("kinetic", "strain", "damping", "method"))
    terms["residual"] = terms["initial"] + terms["loads"] + terms["maneuver"] - taken
    return {name: float(terms[name]) for name in TERMS}


def energies_at(
    equation: EquationOfMotion, maneuver: Maneuver | FreeHub, segments: tuple[Segment, ...], at: MotionState
) -> Energies:
    """Energies of a state of the full model."""
    moved, inertia = equation.moved, equation.inertia if equation.moved is None else equation.moved.system.inertia
    body = equation.body if isinstance(equation, HubEquation) else tuple(Body.of(inertia, None))
    twist = at.hub.twist if isinstance(at, HubMotion) else frame_twist(maneuver, segments, at.time)
    equation.set_time(at.time)
    elastic, strain = 0.5 * equation.products.mass_norm(at.v), equation.strain_energy(at.q)
    if moved is None:
        return Energies(elastic, carried_energy(body, at.q, at.v, twist), strain)
    # What supports add is prescribed as the frame's motion is.
    carried = carried_energy(body, *moved.whole(at.q, at.v), twist) + moved.kinetic_energy(at.v) - elastic
    return Energies(elastic, carried, strain)


def frame_twist(maneuver: Maneuver | FreeHub, segments: tuple[Segment, ...], time: float) -> Array:
    """Velocity of the frame's origin and angular velocity in its own axes at an instant, shape (6,).

    Before the start the frame turns steadily about a line that rests, or does not turn and rests; from then on
    ``dv0 = a0 - w x v0``.
    """
    assert isinstance(maneuver, Maneuver)
    steady = maneuver.start()
    spin, square = steady.angular_velocity, float(np.sum(steady.angular_velocity**2))
    velocity = cross(steady.origin_acceleration, spin) / square if square > 0.0 else np.zeros(3)
    motion = segments[0].motion(0.0)
    for segment in segments:
        end = min(segment.end, time)
        if end > segment.start:
            velocity = _pushed(velocity, segment, end)
        motion = segment.motion(end)
        if segment.end > time:
            break
    return np.concatenate([velocity, motion.angular_velocity])


def _pushed(velocity: Array, segment: Segment, end: float) -> Array:
    """Velocity of the origin at an instant of a segment from that at its start."""

    def rate(time: float, now: Array) -> Array:
        motion: RigidMotion = segment.motion(time)
        return motion.origin_acceleration - cross(motion.angular_velocity, now)

    if not (velocity.any() or any(rate(t, velocity).any() for t in np.linspace(segment.start, end, 9))):
        return velocity
    from scipy.integrate import solve_ivp  # here, because the command line does without

    way = solve_ivp(rate, (segment.start, end), velocity, method="DOP853", rtol=1e-11, atol=1e-14)
    return np.asarray(way.y[:, -1], dtype=np.float64)
