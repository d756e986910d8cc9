"""Spinning structures with known frequencies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tautflex import BeamSection, CableSection, Material, MembraneSection, Model, solve_prestress
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.structure.model import Support
from verification.builders import beam_line, disc_mesh, unstressed

Array = NDArray[np.float64]

POISSON_RATIO = 0.3


def spinning_disc(rings: int) -> PrestressedState:
    """Film disc of radius 1 m, rho = 1000 kg/m^3, for a spin of about 1 rad/s.

    Its stress comes from the spin, about 400 Pa at 1 rad/s, with strains of 4e-7; the given 4e-5 Pa only keep the
    first Newton step regular. The centre is held in the plane, a rim node against turning; a soft cable below the
    centre replaces the free heave by one of 1e-3 rad/s.
    """
    nodes, triangles = disc_mesh(1.0, rings)
    rim = int(np.argmax(nodes[:, 0]))
    centre, ground = 0, len(nodes)
    mass = 1000.0 * 1e-3 * np.pi
    model = Model.from_mesh(
        np.vstack([nodes, [0.0, 0.0, -1.0]]),
        triangles=triangles,
        membrane=MembraneSection(Material(1e9, 1000.0, POISSON_RATIO), 1e-3, "green-lagrange"),
        membrane_stress=(4e-5, 4e-5, 0.0),
        cables=np.array([[ground, centre]]),
        cable=CableSection(Material(1e-6 * mass, 1e-9), 1.0),
        cable_tension=1e-12,
        supports=(Support.pinned(ground), Support((centre,), ("x", "y")), Support((rim,), ("y",))),
    )
    return solve_prestress(model)


def disc_ratio(diameters: int, circles: int) -> float:
    """(w/W)^2 of a free spinning membrane disc [Lamb & Southwell 1921]."""
    m, s, nu = diameters, diameters + 2 * circles, POISSON_RATIO
    return (s * (s + 2) * (3.0 + nu) - m**2 * (1.0 + 3.0 * nu)) / 8.0


def rotating_cantilever(elements: int) -> PrestressedState:
    """Cantilever along x from the spin axis z, L = rho A = EI_y = 1; stiff along itself and in the spin plane.

    Sections of radius 1e-4 leave out rotary inertia; EA = 1e8 keeps the stretch at 1e-7 of the length.
    """
    section = BeamSection(Material(1e12, 1e4, 0.3), 1e-4, 1e-12, 1e-10, 1e-12)
    return unstressed(beam_line(section, 1.0, elements, (Support.clamped(0),)))


def held_particle(frequency: float, ratio: float = 1.0) -> PrestressedState:
    """Free node at the origin between six cables along the axes, a third of whose mass moves with it.

    Its frequency [Hz] is ``frequency`` along x and z, and ``ratio`` times that along y.
    """
    ends = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]])
    density, area = 1.0, 1.0
    mass = 6.0 * density * area / 3.0
    stiffness = 0.5 * mass * (2.0 * np.pi * frequency) ** 2
    moduli = stiffness * np.array([1.0, 1.0, ratio**2, ratio**2, 1.0, 1.0])
    return _star(ends, moduli, density, area)


def _star(ends: Array, moduli: Array, density: float, area: float) -> PrestressedState:
    """One free node at the origin and a cable of its own modulus to each end."""
    nodes = np.vstack([np.zeros(3), ends])
    cables = np.column_stack([np.zeros(len(ends), dtype=int), np.arange(1, len(nodes))])
    tension = 1e-9 * float(moduli.min())
    parts = [
        Model.from_mesh(
            nodes[[0, k + 1]],
            cables=np.array([[0, 1]]),
            cable=CableSection(Material(float(modulus), density), area),
            cable_tension=tension,
        ).groups[0]
        for k, modulus in enumerate(moduli)
    ]
    groups = tuple(replace(part, connectivity=cables[k : k + 1]) for k, part in enumerate(parts))
    return solve_prestress(Model(nodes, groups, (Support.pinned(np.arange(1, len(nodes))),), "uniform"))
