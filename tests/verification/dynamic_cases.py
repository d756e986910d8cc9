"""Small structures with known motion, shared by the tests of integrators and dynamics."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from tautflex import (
    AtRest,
    BeamSection,
    CableSection,
    Maneuver,
    Material,
    MembraneSection,
    Model,
    RigidMotion,
    Segment,
    solve_prestress,
)
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.structure.antenna import AntennaLayout, build_antenna, build_fixed_film
from tautflex.structure.model import Support

# Linear tests move this slowly: nonlinear terms then vanish below round-off of the linear ones.
TINY_VELOCITY = 1e-6


def string(
    elements: int,
    *,
    length: float = 1.0,
    tension: float = 1.0,
    modulus: float = 1e3,
    area: float = 1e-2,
    density: float = 100.0,
    free_directions: str = "xyz",
    free_end: bool = False,
    strain: str = "von-karman",
) -> PrestressedState:
    """Taut string along x from the origin, pinned at both ends unless ``free_end``; rho A = 1 kg/m."""
    nodes = np.zeros((elements + 1, 3))
    nodes[:, 0] = np.linspace(0.0, length, elements + 1)
    ends = [0] if free_end else [0, elements]
    held = tuple(axis for axis in "xyz" if axis not in free_directions)
    supports = [Support.pinned(ends)]
    if held:
        supports.append(Support(tuple(range(elements + 1)), held))
    model = Model.from_mesh(
        nodes,
        cables=np.column_stack([np.arange(elements), np.arange(1, elements + 1)]),
        cable=CableSection(Material(modulus, density), area, strain),
        cable_tension=tension,
        supports=supports,
    )
    return solve_prestress(model)


def oscillator(frequency: float = 1.0) -> PrestressedState:
    """One unknown: a string of two elements whose middle moves along z.

    Stiffness 4 T / L, consistent mass rho A L / 3, so that T = rho A L^2 (2 pi f)^2 / 12.
    """
    return string(2, tension=(2.0 * np.pi * frequency) ** 2 / 12.0, modulus=1.0, free_directions="z")


def soft_film(divisions: tuple[int, int] = (4, 3), strain: str = "von-karman") -> PrestressedState:
    """Fixed-edge film whose in-plane waves are slow enough for every step of the tests to resolve them."""
    film = MembraneSection(Material(2e5, 1000.0, 0.3), 1e-3, strain)
    layout = AntennaLayout(1.0, 0.8, divisions)
    return solve_prestress(build_fixed_film(layout, film, (4e3, 3e3, 0.0)))


def small_antenna(divisions: tuple[int, int] = (4, 2), strain: str = "von-karman", scale: float = 1.0) -> Model:
    """Coarse version of the paper's antenna in the published reading, clamped at the frame's corners."""
    layout = AntennaLayout(2.0, 1.0, divisions, "regular", 2.5, 1.5, divisions[0] + 1, divisions[1] + 1)
    tension_x, tension_y = 1.475 * scale, 2.5 * scale
    return build_antenna(
        layout,
        MembraneSection(Material(3.5e9, 1530.0, 0.34), 1e-4, strain),
        CableSection(Material(133e9, 1440.0), 3.14e-6, strain),
        BeamSection(Material(3e9, 1380.0, 0.38), 5.24e-4, 4.81e-7, 2.69e-7, 7.5e-7, strain),
        pretension_x=tension_x,
        pretension_y=tension_y,
        membrane_stress=(0.283 * tension_x / 1e-4, 0.219 * tension_y / 1e-4, 0.0),
        prestress_mode="uniform",
    )


def moved(model: Model, rotation: np.ndarray, shift: np.ndarray) -> Model:
    """Copy of a model with every position and local direction turned, then shifted."""
    groups = tuple(
        replace(group, orientation=rotation @ _own_direction(group.section.kind, group.orientation))
        for group in model.groups
    )
    return replace(model, nodes=model.nodes @ rotation.T + shift, groups=groups)


def _own_direction(kind: str, orientation: np.ndarray) -> np.ndarray:
    # A cable is isotropic across its axis: leaving its direction behind checks just that.
    return orientation if kind != "cable" else np.array([0.3, -0.5, 0.8])


@dataclass(frozen=True)
class Release(Maneuver):
    """A frame that moves steadily until t = 0 and then rests: initial displacement, no initial velocity."""

    spin: RigidMotion

    def start(self) -> RigidMotion:
        return self.spin

    def segments(self) -> tuple[Segment, ...]:
        return AtRest().segments()


@dataclass(frozen=True)
class SuddenSpin(Maneuver):
    """A frame at rest until t = 0 whose motion is then that of another maneuver."""

    then: object = field()

    def start(self) -> RigidMotion:
        return AtRest().start()

    def segments(self) -> tuple[Segment, ...]:
        return self.then.segments()


def transverse_spin(acceleration: float) -> RigidMotion:
    """Frame whose origin accelerates along z: a uniform transverse load."""
    return RigidMotion(np.zeros(3), np.zeros(3), np.array([0.0, 0.0, acceleration]))


def two_term_root(record: np.ndarray) -> complex:
    """Root with positive imaginary part of the best recurrence w[n+2] = s w[n+1] - p w[n] of a record."""
    matrix = np.column_stack([record[1:-1], -record[:-2]])
    (total, product), *_ = np.linalg.lstsq(matrix, record[2:], rcond=None)
    return complex(0.5 * total, np.sqrt(product - 0.25 * total**2))
