"""Static equilibrium under dead loads, steady rotation and follower pressure."""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError, NotConvergedError, UnstableWarning
from tautflex.mechanics.loads.pressure import PressureLoad, nodal_load
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import RigidMotion
from tautflex.numeric import Array
from tautflex.solvers.nonlinear.minimum import find_minimum
from tautflex.solvers.nonlinear.newton import NewtonOutcome
from tautflex.solvers.plausibility import point_text
from tautflex.solvers.static.pivots import find_fall
from tautflex.solvers.static.prestress import PrestressedState, require_state
from tautflex.solvers.static.residual import StaticResidual
from tautflex.solvers.static.softening import softened
from tautflex.text import shown

# First shift of a descent that starts without transverse stiffness; steps of the order of the final deflection.
_SOFT_START, _ON_THE_WAY = 1e-4, 1e-6
# Factorizations of one descent, and of the first one.
_MOST, _MOST_AT_ONCE = 1000, 100
_TOLERANCE = 1e-9


def solve_static(
    state: PrestressedState,
    load: ArrayLike | None = None,
    extra: ArrayLike | None = None,
    tolerance: float = _TOLERANCE,
    *,
    forces: ArrayLike | None = None,
    pressure: PressureLoad | None = None,
    steps: int = 1,
    start: ArrayLike | None = None,
) -> Array:
    """Nonlinear static equilibrium ``f_int(q) - f_ref + K_T q + load - f_pressure(q) = 0``.

    Parameters
    ----------
    state
        Prestressed state.
    load
        Load on the left-hand side (its negative acts on the structure) [N, N m], shape (size,); None is none.
    extra
        Values of an additional symmetric stiffness K_T in the pattern, shape (entries,).
    tolerance
        Allowed ratio of residual norm to the norm of the forces, > 0 and < 1; their round-off bounds it from below.
    forces
        Dead forces that act on the nodes [N], shape (node, 3); None is none.
    pressure
        Follower pressure on the film.
    steps
        Equal steps in which load, forces and pressure are applied.
    start
        First guess [m, rad], shape (size,); None is the reference.

    Returns
    -------
    numpy.ndarray
        Free unknowns [m, rad], shape (size,); ``state.system.translations`` makes displacements of the nodes of them.

    Raises
    ------
    InputError
        If an argument has the wrong shape or value, or ``pressure`` belongs to another structure.
    NotConvergedError
        If no equilibrium is found; ``.result`` holds the last point, shape (size,).

    Warns
    -----
    UnstableWarning
        If small motion leaves the equilibrium, as it leaves a compressed film that stays flat.

    Notes
    -----
    Newton's method is tried first, under pressure with the unsymmetric load stiffness of free edges. Where it fails, or
    finds a shape that pressure would leave, a stable equilibrium is sought by `find_minimum`, from the elastic law to
    those that wrinkle and go slack. It also finds inflated and hanging shapes from a start without tension.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> moved = state.system.translations(tf.solve_static(state, pressure=tf.PressureLoad(state, 1e-3)))
    >>> print(f"{1e3 * abs(moved[:, 2]).max():.3f} mm under 1 mPa")
    0.227 mm under 1 mPa
    """
    require_state(state)
    system = state.system
    if not 0.0 < checks.finite("tolerance", tolerance) < 1.0:
        raise InputError(f"tolerance: expected a number > 0 and < 1, got {tolerance!r}; 1e-9 is the default")
    checks.whole("steps", steps, 1)
    dead = np.zeros(system.size) if load is None else checks.float_array("load", load, (system.size,))
    if forces is not None:
        dead = dead - nodal_load(system, forces)
    if extra is not None:
        extra = checks.float_array("extra", extra, (system.pattern.entries,))
    if pressure is not None and not (isinstance(pressure, PressureLoad) and pressure.belongs_to(system)):
        given = "one on another structure" if isinstance(pressure, PressureLoad) else shown(pressure)
        raise InputError(
            f"pressure: expected a load on the film of this state, got {given}; give PressureLoad(state, 1.0)"
        )
    x = np.zeros(system.size) if start is None else checks.float_array("start", start, (system.size,))
    problem = StaticResidual(system, state.reference_force, tolerance, dead, extra, pressure)
    x = _in_steps(problem, x, tolerance, steps)
    _tell_if_unstable(problem, x)
    return x


def _in_steps(problem: StaticResidual, x: Array, tolerance: float, steps: int = 1) -> Array:
    """Equilibrium under the whole load, applied in equal steps."""
    with np.errstate(over="ignore", invalid="ignore"):  # what leaves the range of numbers is told by the error
        for step in range(1, steps + 1):
            problem.share = step / steps
            x = _solve(problem, x, tolerance)
    return x


def _solve(problem: StaticResidual, x: Array, tolerance: float) -> Array:
    """Equilibrium near ``x``: with the laws as they are, or, if that is far, on the way that `softened` makes."""
    own, outcome = problem.system.blocks, NewtonOutcome(x)
    for number, blocks in enumerate((own, *softened(own))):
        problem.use(blocks)
        goal = tolerance if blocks is own else _ON_THE_WAY
        found = problem.newton(outcome.x, goal)
        if found is None:
            shift, most = (0.0, _MOST) if number else (_SOFT_START, _MOST_AT_ONCE)
            outcome = find_minimum(problem, problem.pattern, outcome.x, goal, first_shift=shift, max_iterations=most)
        else:
            outcome = NewtonOutcome(found, converged=True)
        if outcome.converged and blocks is own:
            return outcome.x
        if number and not outcome.converged:
            break
    raise _failure(problem, outcome)


def _tell_if_unstable(problem: StaticResidual, x: Array) -> None:
    """Warn of an equilibrium that small motion leaves."""
    system, values = problem.system, problem.tangent(x)
    fall = find_fall(system, 0.5 * (values + values[system.pattern.transpose_slots]), x)
    if fall is None:
        return
    node = int(np.argmax(np.linalg.norm(system.translations(fall.vector), axis=1)))
    warnings.warn(
        f"solve_static: the equilibrium is unstable, its energy falls in {fall.directions} direction(s), most at node "
        f"{node} {point_text(system.model.nodes[node])}: a real structure buckles or snaps away from there; apply "
        "less, raise the tension, or give a start (or a small force) to the side to which it goes",
        UnstableWarning,
        stacklevel=3,
    )


def _failure(problem: StaticResidual, descent: NewtonOutcome) -> NotConvergedError:
    """What went wrong, and what to try."""
    error = descent.history[-1]
    if not np.isfinite(error):
        text = "the forces leave the range of numbers; check the units of load, pressure and start"
    elif not problem.stable(descent.x):
        text = (
            "the structure gives way there: load, spin or compression leave no stable shape nearby; check supports, "
            "raise the tension, or apply less"
        )
    else:
        text = "what supports and tension do not hold drifts on; check them, or give a nearer start, or more steps"
    return NotConvergedError(
        f"static equilibrium: residual {error:.2e} of the forces after {descent.iterations} factorizations; {text}",
        result=descent.x,
        history=tuple(descent.history),
    )


def spinning_equilibrium(state: PrestressedState, motion: RigidMotion, coupling: Coupling) -> Array:
    """Steady equilibrium in a frame that moves with constant ``motion`` [theory.md 4], shape (size,)."""
    inertia = state.system.inertia
    load = coupling.load(motion, coupling.moments(state.system))
    weight = coupling.displacement_weight(motion)
    if not load.any() and not weight.any():
        return np.zeros(state.system.size)
    extra = inertia.entries(weight) if weight.any() else None
    problem = StaticResidual(state.system, state.reference_force, _TOLERANCE, load, extra)
    return _in_steps(problem, np.zeros(state.system.size), _TOLERANCE)
