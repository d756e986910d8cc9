"""Natural modes about the prestressed state [theory.md 6]."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.inertia import InertiaOperator
from tautflex.motion.hub import FreeHub
from tautflex.numeric import Array, cross_matrix, within_arithmetic
from tautflex.solvers.linear.eigenpairs import lowest_eigenpairs
from tautflex.solvers.modal.labels import FilmSampler, half_wave_labels, symmetry_class
from tautflex.solvers.modal.rigid import RIGID_DIRECTIONS, rigid_loads, rigid_mass
from tautflex.solvers.static.prestress import PrestressedState, in_short, require_state
from tautflex.solvers.variables import COMPONENTS, MODES, described, mesh_variables
from tautflex.text import card, span

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Modes:
    """Natural modes, in order of frequency.

    Parameters
    ----------
    state
        The prestressed state.
    frequencies
        Natural frequencies [Hz], shape (mode,); the negative root stands for an unstable mode.
    vectors
        Free unknowns, mass-normalised ``phi' M phi = 1``, largest translation positive, shape (mode, size).
    labels
        Half-wave numbers (m, n) of transverse film modes, None for others.
    symmetry
        Two letters: S or A under x -> -x, then under y -> -y; "-" for neither.
    effective_mass
        Squared participation of rigid accelerations along and about x, y, z [kg, kg m^2], shape (mode, 6).
    """

    state: PrestressedState
    frequencies: Array
    vectors: Array
    labels: list[tuple[int, int] | None]
    symmetry: list[str]
    effective_mass: Array

    def __repr__(self) -> str:
        shapes = zip(self.frequencies, self.labels, self.symmetry, strict=True)
        lines = {
            "state": in_short(self.state),
            "modes": f"{len(self.frequencies)}, {span(self.frequencies, 'Hz')}",
            **{
                f"mode {number}": f"{value:.4g} Hz  {label or ''} {symmetry}"
                for number, (value, label, symmetry) in enumerate(shapes, start=1)
            },
        }
        return card(self, lines)

    @property
    def shapes(self) -> Array:
        """Translations of all nodes [kg^-1/2], shape (mode, node, 3)."""
        return self.state.system.translations(self.vectors)

    @property
    def data(self) -> xr.Dataset:
        """Modes and mesh as a Dataset, by the name that it has of a run."""
        return self.to_dataset()

    def to_dataset(self) -> xr.Dataset:
        """Modes and mesh as a Dataset with units on every variable."""
        import xarray as xr  # half a second, which a case that is refused need not wait for

        label = np.array([pair or (0, 0) for pair in self.labels])
        data = {
            "frequency": self.frequencies,
            "shape": self.shapes,
            "label_m": label[:, 0],
            "label_n": label[:, 1],
            "symmetry": np.array(self.symmetry, dtype=str),
            "effective_mass": self.effective_mass,
        }
        state = self.state
        return xr.Dataset(
            {**described(MODES, data), **mesh_variables(state.model)},
            coords={
                "mode": np.arange(1, len(self.frequencies) + 1),
                "component": COMPONENTS,
                "direction": list(RIGID_DIRECTIONS),
            },
            attrs={
                "title": "natural modes about the prestressed state",
                "normalisation": "phi' M phi = 1, largest translation positive",
                "prestress": json.dumps(
                    {"residual": state.residual, "min_principal_resultant": state.min_principal_resultant}
                ),
            },
        )


@within_arithmetic()
def solve_modes(
    state: PrestressedState, n: int = 10, *, about: ArrayLike | None = None, hub: FreeHub | None = None
) -> Modes:
    """Lowest natural modes by sparse shift-invert Lanczos.

    Parameters
    ----------
    state
        Prestressed state.
    n
        Number of modes, at least 1 and below the number of unknowns.
    about
        Free unknowns of a loaded state that the motion is about [m, rad], shape (size,), as `solve_static` gives them;
        None is the reference. Its loads are dead: the stiffness of a pressure that follows the film is left out.
    hub
        Hub that is free to move and carries the supports; None: they rest. Motion and momentum of both balance, shapes
        are relative to the hub, rigid motion is left out [Likins 1970, NASA TR 32-1329].

    Returns
    -------
    Modes
        On a hub ``phi' M phi = 1`` counts the motion of the hub too.

    Raises
    ------
    InputError
        If ``n`` is out of range, or ``about`` has another shape.
    NotConvergedError
        If the eigensolver fails.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> modes = tf.solve_modes(state, n=3)
    >>> modes.frequencies.shape, modes.labels[0]
    ((3,), (1, 1))
    """
    require_state(state)
    system = state.system
    if not 1 <= checks.whole("n", n, 0) < system.size:
        raise InputError(f"n: expected 1 to {system.size - 1} modes, got {n}; refine the mesh for more")
    stiffness = state.tangent_entries
    if about is not None:
        stiffness = system.tangent(checks.float_array("about", about, (system.size,)))
    checks.instance("hub", hub, (FreeHub, type(None)), "a FreeHub(...), or None")
    carried = None if hub is None else _carried(system.inertia, hub)
    values, vectors = lowest_eigenpairs(system.pattern, stiffness, system.inertia.mass_entries, n, carried)
    frequencies = np.sign(values) * np.sqrt(np.abs(values)) / (2.0 * np.pi)
    translations = system.translations(vectors)
    flat = translations.reshape(n, -1)
    vectors = vectors * np.sign(flat[np.arange(n), np.abs(flat).argmax(axis=1)])[:, None]
    labels, symmetry = describe_shapes(state, system.translations(vectors))
    return Modes(state, frequencies, vectors, labels, symmetry, (vectors @ rigid_loads(system.inertia).T) ** 2)


def _carried(inertia: InertiaOperator, hub: FreeHub) -> tuple[Array, Array]:
    """Rows of the free rigid accelerations, and the inverse of the mass that resists them."""
    origin, center = np.zeros(3), np.asarray(hub.center, dtype=float)
    turn = hub.mass * cross_matrix(center)
    tensor = hub.tensor + hub.offset_inertia
    whole = rigid_mass(inertia, origin) + np.block([[hub.mass * np.eye(3), -turn], [turn, tensor]])
    free = np.flatnonzero(hub.freedom)
    return rigid_loads(inertia)[free], np.linalg.inv(whole[np.ix_(free, free)])


def describe_shapes(state: PrestressedState, shapes: Array) -> tuple[list[tuple[int, int] | None], list[str]]:
    """Half-wave labels and symmetry classes of shapes (mode, node, 3) from the film's nodes."""
    model = state.model
    used = np.unique(model.triangles)
    if not used.size:
        return [None] * len(shapes), ["--"] * len(shapes)
    sampler = FilmSampler(model.nodes[used])
    films = [shape[used] for shape in shapes]
    labels = [half_wave_labels(sampler, film[:, 2], in_plane=film[:, :2]) for film in films]
    return labels, [symmetry_class(sampler, film[:, 2]) for film in films]
