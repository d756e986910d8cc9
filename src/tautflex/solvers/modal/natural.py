"""Natural modes about the prestressed state [theory.md 6]."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from tautflex.errors import InputError
from tautflex.mechanics.inertia import cross_matrix
from tautflex.solvers.linear.eigenpairs import lowest_eigenpairs
from tautflex.solvers.modal.labels import FilmSampler, half_wave_labels, symmetry_class
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.variables import mesh_variables

Array = NDArray[np.float64]

RIGID_DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")


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

    @property
    def shapes(self) -> Array:
        """Translations of all nodes [kg^-1/2], shape (mode, node, 3)."""
        return self.state.system.translations(self.vectors)

    def to_dataset(self) -> xr.Dataset:
        """Modes and mesh as a Dataset with units on every variable."""
        label = np.array([pair or (0, 0) for pair in self.labels])
        dims = ("mode", "node", "component")
        data = {
            "frequency": ("mode", self.frequencies, _about("natural frequency", "Hz")),
            "shape": (dims, self.shapes, _about("mass-normalised mode shape", "kg^-1/2")),
            "label_m": ("mode", label[:, 0], _about("half-waves along x, 0 where none", "1")),
            "label_n": ("mode", label[:, 1], _about("half-waves along y, 0 where none", "1")),
            "symmetry": (
                "mode",
                np.array(self.symmetry, dtype=str),
                _about("symmetry about x = 0 and y = 0", "1"),
            ),
            "effective_mass": (
                ("mode", "direction"),
                self.effective_mass,
                _about("effective mass (x, y, z) and inertia (rx, ry, rz)", "kg, kg m^2"),
            ),
        }
        state = self.state
        return xr.Dataset(
            {**data, **mesh_variables(state.model)},
            coords={
                "mode": np.arange(1, len(self.frequencies) + 1),
                "component": ["x", "y", "z"],
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


def _about(long_name: str, units: str) -> dict[str, str]:
    return {"long_name": long_name, "units": units}


def solve_modes(state: PrestressedState, n: int = 10) -> Modes:
    """Lowest natural modes by sparse shift-invert Lanczos.

    Parameters
    ----------
    state
        Prestressed state.
    n
        Number of modes, at least 1 and below the number of unknowns.

    Returns
    -------
    Modes

    Raises
    ------
    InputError
        If ``n`` is out of range.
    NotConvergedError
        If the eigensolver fails.
    """
    system = state.system
    if not 1 <= n < system.size:
        raise InputError(f"n: expected 1 to {system.size - 1} modes, got {n}; refine the mesh for more")
    values, vectors = lowest_eigenpairs(system.pattern, state.tangent_entries, system.inertia.mass_entries, n)
    frequencies = np.sign(values) * np.sqrt(np.abs(values)) / (2.0 * np.pi)
    translations = system.translations(vectors)
    flat = translations.reshape(n, -1)
    vectors = vectors * np.sign(flat[np.arange(n), np.abs(flat).argmax(axis=1)])[:, None]
    labels, symmetry = describe_shapes(state, system.translations(vectors))
    return Modes(state, frequencies, vectors, labels, symmetry, _effective_mass(state, vectors))


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


def _effective_mass(state: PrestressedState, vectors: Array) -> Array:
    """Squared participation factors of unit rigid accelerations, shape (mode, 6)."""
    inertia = state.system.inertia
    loads = [inertia.zeroth_moment[axis] for axis in range(3)]
    loads += [inertia.load(cross_matrix(np.eye(3)[axis])) for axis in range(3)]
    return (vectors @ np.array(loads).T) ** 2
