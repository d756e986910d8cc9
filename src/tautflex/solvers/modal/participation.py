r"""Rigid-elastic coupling of an appendage, as tools for attitude control want it.

The supports are the interface to the hub, which accelerates by ``a`` (three translations of a point P, three
rotations about it). With mass-normalised modes of the supported structure [Likins 1970, JPL TR 32-1329; Alazard,
Perez, Cumer & Loquen 2015, AIAA SciTech]:

    eta_j'' + 2 zeta_j w_j eta_j' + w_j^2 eta_j = -p_j . a,        p_j = int rho (phi_j, (x - x_P) x phi_j),
    force and torque on the hub at P:  F = -M_rigid a - sum p_j eta_j'' = -D(s) a,
    D(s) = M_rigid - sum p_j p_j' s^2 / (s^2 + 2 zeta_j w_j s + w_j^2).

The effective masses ``p_j^2`` of all modes sum up to the mass that the supports leave free [Imbert 1979, Analyse des
structures par elements finis]; what the kept modes leave, ``M_residual = M_rigid - sum p_j p_j'``, follows the hub
rigidly.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike
from scipy.sparse.linalg import splu

from tautflex import checks
from tautflex.errors import InputError, UnsupportedError
from tautflex.mechanics.dampings.damping import Damping
from tautflex.mechanics.dampings.rayleigh import Rayleigh
from tautflex.mechanics.inertia import InertiaOperator
from tautflex.numeric import Array, Complex
from tautflex.solvers.modal.natural import Modes
from tautflex.solvers.modal.rigid import RIGID_DIRECTIONS, rigid_loads, rigid_mass
from tautflex.solvers.variables import APPENDAGE, COMPONENTS, dataset_of, described

# Six of them: a structure that is not held at all has no interface to a hub.
_FREE = 6


def appendage_data(
    modes: Modes, point: ArrayLike = (0.0, 0.0, 0.0), damping: Damping | ArrayLike | None = None
) -> xr.Dataset:
    """Participation of the modes in rigid motions of the supports, and the rigid masses, about a point.

    Parameters
    ----------
    modes
        Normal modes of the supported structure.
    point
        Reference point P in the floating frame [m], shape (3,).
    damping
        `Rayleigh`, `Modal` or any other `Damping`, or damping ratios, one for all modes or shape (mode,); by default
        none but the structure's dampers. Of a damping that couples modes, the modes' own terms are taken.

    Returns
    -------
    xarray.Dataset
        ``participation(mode, direction)`` [kg^1/2, kg^1/2 m], ``effective_mass(mode, direction)`` [kg, kg m^2],
        ``frequency(mode)`` [Hz], ``damping_ratio(mode)``; 6 x 6 over (direction, other_direction) about P:
        ``rigid_mass``, ``free_mass`` (limit of the sum of ``p p'`` over all modes), ``residual_mass`` (rigid less the
        sum over these modes) [kg, kg m, kg m^2]; ``completeness(direction)``, the part of the free mass that these
        modes hold; ``point(component)`` [m]. Directions are x, y, z, rx, ry, rz.

    Raises
    ------
    UnsupportedError
        If nothing holds the structure.
    InputError
        If ``point`` or ``damping`` has the wrong shape or value.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> data = tf.appendage_data(tf.solve_modes(state, n=5))
    >>> list(data.data_vars)[:3]
    ['frequency', 'damping_ratio', 'participation']
    """
    checks.instance("modes", modes, Modes, "the Modes of a state", remedy="solve_modes(state) gives them")
    place = checks.vector3("point", point)
    model, inertia = modes.state.model, modes.state.system.inertia
    if model.rigid_freedom == _FREE:
        raise UnsupportedError(
            "modes: expected a structure held by supports, its interface to the hub, got a free one; give supports"
        )
    loads = rigid_loads(inertia, place)
    participation = modes.vectors @ loads.T
    rigid, shared = rigid_mass(inertia, place), participation.T @ participation
    free = _free_mass(inertia, loads)
    held = np.diag(free) > 1e-12 * np.diag(rigid)
    complete = np.divide(np.diag(shared), np.diag(free), out=np.full(6, np.nan), where=held)
    data = {
        "frequency": modes.frequencies,
        "damping_ratio": _damping_ratios(modes, damping),
        "participation": participation,
        "effective_mass": participation**2,
        "rigid_mass": rigid,
        "free_mass": free,
        "residual_mass": rigid - shared,
        "completeness": complete,
        "point": place,
    }
    return xr.Dataset(
        described(APPENDAGE, data),
        coords={
            "mode": np.arange(1, len(modes.frequencies) + 1),
            "direction": list(RIGID_DIRECTIONS),
            "other_direction": list(RIGID_DIRECTIONS),
            "component": COMPONENTS,
        },
        attrs={
            "title": "rigid-elastic coupling of the appendage",
            "equations": "eta'' + 2 zeta w eta' + w^2 eta = -P a; F = -rigid_mass a - P' eta''",
            "normalisation": "phi' M phi = 1",
        },
    )


def dynamic_mass(data: xr.Dataset, frequencies: ArrayLike) -> Complex:
    """Matrix ``D(i w)`` from acceleration of the point to minus force and torque there.

    Parameters
    ----------
    data
        What `appendage_data` gives.
    frequencies
        Where to evaluate it [Hz], shape (f,).

    Returns
    -------
    numpy.ndarray
        Complex [kg, kg m, kg m^2], shape (f, 6, 6); the rigid mass matrix at zero frequency.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> data = tf.appendage_data(tf.solve_modes(state, n=4))
    >>> print(f"{tf.dynamic_mass(data, [0.0])[0, 0, 0].real:.3f} kg at rest")
    6.129 kg at rest
    """
    data = dataset_of("data", data, "participation", "rigid_mass", remedy="appendage_data(modes, point) gives it")
    s = 2j * np.pi * checks.float_array("frequencies", frequencies, (None,))[:, None]
    natural, ratio = 2.0 * np.pi * data["frequency"].values, data["damping_ratio"].values
    gain = s**2 / (s**2 + 2.0 * ratio * natural * s + natural**2)
    participation = data["participation"].values
    return data["rigid_mass"].values - np.einsum("fj,ja,jb->fab", gain, participation, participation)


def _free_mass(inertia: InertiaOperator, loads: Array) -> Array:
    """Sum of ``p p'`` over all modes: ``L M^-1 L'``, whose basis of modes need not be complete."""
    return loads @ splu(inertia.pattern.matrix(inertia.mass_entries)).solve(loads.T)


def _damping_ratios(modes: Modes, damping: Damping | ArrayLike | None) -> Array:
    count = len(modes.frequencies)
    if damping is None:
        damping = Rayleigh()
    if isinstance(damping, Damping):
        natural = 2.0 * np.pi * np.abs(modes.frequencies)
        linear, vectors = modes.state.linear, modes.vectors
        matrix = damping.of(linear)
        own = matrix.mass + np.sum(vectors * matrix.low_rank_force(vectors.T).T, axis=1)
        if matrix.kinds:
            besides = replace(matrix, mass=0.0, stiffness=0.0).proportional(0.0, 0.0, linear.projected(vectors))
            own = own + besides.diagonal()
        if (matrix.mass > 0.0 or any(mass for mass, _ in matrix.kinds.values())) and not natural.all():
            raise InputError(
                "damping: expected modes of non-zero frequency under damping in proportion to mass; add supports"
            )
        from_mass = np.divide(own, 2.0 * natural, out=np.zeros(count), where=natural > 0.0)
        return from_mass + 0.5 * matrix.stiffness * natural
    ratios = checks.numbers("damping", damping)
    if ratios.shape not in ((), (count,)) or not np.all(ratios >= 0.0):
        raise InputError(f"damping: expected one ratio >= 0, or {count} of them, got {ratios.tolist()}")
    return np.array(np.broadcast_to(ratios, (count,)))
