"""Campbell table: frequencies of a spinning structure over the rate, as continuous branches [theory.md 6]."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment

from tautflex import checks
from tautflex.errors import InputError, NotConvergedError
from tautflex.mechanics.dampings.damping import Damping
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import unit_axis
from tautflex.numeric import Array, Indices
from tautflex.solvers.modal.spinning import SpinningModes, solve_spinning_modes
from tautflex.solvers.static.prestress import PrestressedState, require_state
from tautflex.solvers.variables import CAMPBELL, described

Progress = Callable[[float, str], None]

# A link below this is looked at more closely, with rates halved at most so many times.
_SURE = 0.7
_HALVINGS = 3
# Decides between shapes that look equally alike, as those of a double frequency do.
_NEARNESS = 0.1


def campbell(
    state: PrestressedState,
    rates: ArrayLike,
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0),
    n: int = 10,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    coupling: Coupling | None = None,
    damping: Damping | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Frequencies over the spin rate, each branch one shape that changes gradually.

    Branches are joined from rate to rate by the mass-weighted modal assurance criterion
    ``|phi_a^H M phi_b|^2`` [paper, eq. (54)], all at once (the assignment of largest sum), so that they run through
    crossings. Where a link is unsure, rates in between are solved for. A link that stays below 0.5 is none: the shape
    is lost, as where the film buckles.

    Parameters
    ----------
    state
        Prestressed state.
    rates
        Angular rates [rad/s], increasing or decreasing, shape (rate,).
    axis, origin
        Direction of the spin axis and a point on it [m].
    n
        Number of branches: the lowest modes at the first rate.
    coupling, damping
        As for `solve_spinning_modes`.
    progress
        Called with the fraction done (0 to 1) and a short message.

    Returns
    -------
    xarray.Dataset
        Over rate [rad/s] and branch: ``frequency`` [Hz], ``growth_rate`` [1/s], ``damping_ratio``, ``whirl``,
        ``mac`` (weakest link from the rate before; 1 at the first), half-waves ``label_m``, ``label_n`` (0 where
        none); over rate: ``stable`` (of all modes found) and ``min_principal_resultant`` [N/m].

    Raises
    ------
    InputError
        If rates are not monotonic, or another argument is out of range.
    NotConvergedError
        If there is no equilibrium at a rate; ``result`` has the table of the rates before it.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> branches = tf.campbell(state, [0.0, 0.3], n=3)
    >>> dict(branches.frequency.sizes)
    {'rate': 2, 'branch': 3}
    """
    require_state(state)
    values = checks.float_array("rates", rates, (None,))
    steps = np.diff(values)
    if not len(values) or not (np.all(steps > 0.0) or np.all(steps < 0.0)):
        raise InputError(f"rates: expected increasing or decreasing rates [rad/s], got {values}; sort them")
    direction, size = unit_axis(axis), state.system.size
    if not 1 <= checks.whole("n", n, 0) <= size:
        raise InputError(f"n: expected 1 to {size} branches, got {n}; refine the mesh for more")
    # Modes beyond the wanted ones may come down and cross these.
    pool = min(n + max(4, n // 2), size)
    tell = checks.teller(progress)

    def solve(rate: float) -> SpinningModes:
        return solve_spinning_modes(state, rate * direction, origin, pool, coupling, damping)

    found, orders, links = [solve(values[0])], [np.arange(n)], [np.ones(n)]
    try:
        for k, (before, rate) in enumerate(pairwise(values), start=1):
            tell(k / len(values), f"{rate:g} rad/s")
            modes = solve(rate)
            order, link = _follow(solve, found[-1], before, modes, rate, orders[-1], _HALVINGS)
            found, orders, links = [*found, modes], [*orders, order], [*links, link]
    except NotConvergedError as error:
        partial = _table(values[: len(found)], found, orders, links, direction)
        raise NotConvergedError(f"campbell: at {rate:g} rad/s: {error}", partial, error.history) from error
    tell(1.0, "done")
    return _table(values, found, orders, links, direction)


def _follow(
    solve: Callable[[float], SpinningModes],
    first: SpinningModes,
    rate_first: float,
    last: SpinningModes,
    rate_last: float,
    order: Indices,
    halvings: int,
) -> tuple[Indices, Array]:
    """Positions in ``last`` of the modes at positions ``order`` of ``first``, and the weakest link of each."""
    joined, link = _assign(first, last, order)
    if halvings == 0 or link.min() >= _SURE:
        return joined, link
    rate = 0.5 * (rate_first + rate_last)
    middle = solve(rate)
    order, before = _follow(solve, first, rate_first, middle, rate, order, halvings - 1)
    order, after = _follow(solve, middle, rate, last, rate_last, order, halvings - 1)
    return order, np.minimum(before, after)


def _assign(first: SpinningModes, last: SpinningModes, order: Indices) -> tuple[Indices, Array]:
    mass = first.state.system.inertia.mass_matrix
    weighted = np.asarray((mass @ first.vectors[order].conj().T).T)
    alike = np.abs(weighted @ last.vectors.T) ** 2
    here, there = np.abs(first.eigenvalues[order]), np.abs(last.eigenvalues)
    scale = max(float(here.max()), float(np.finfo(float).tiny))
    apart = np.minimum(np.abs(here[:, None] - there) / scale, 1.0)
    _, joined = linear_sum_assignment(_NEARNESS * apart - alike)
    return joined, alike[np.arange(len(order)), joined]


def _table(
    rates: Array, found: list[SpinningModes], orders: list[Indices], links: list[Array], axis: Array
) -> xr.Dataset:
    def branches(name: str) -> Array:
        return np.array([getattr(modes, name)[order] for modes, order in zip(found, orders, strict=True)])

    labels = np.array(
        [[modes.labels[k] or (0, 0) for k in order] for modes, order in zip(found, orders, strict=True)], dtype=int
    )
    data = {
        "frequency": branches("frequencies"),
        "growth_rate": branches("growth_rates"),
        "damping_ratio": branches("damping_ratios"),
        "whirl": branches("whirl"),
        "mac": np.array(links),
        "stable": np.array([modes.stable for modes in found]),
        "min_principal_resultant": np.array([modes.min_principal_resultant for modes in found]),
        "label_m": labels[:, :, 0],
        "label_n": labels[:, :, 1],
    }
    return xr.Dataset(
        described(CAMPBELL, data),
        coords={**described(CAMPBELL, {"rate": rates}), "branch": np.arange(1, labels.shape[1] + 1)},
        attrs={"title": "frequencies of the spinning structure", "axis": axis, "origin": found[0].origin},
    )
