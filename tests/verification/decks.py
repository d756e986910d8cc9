"""Decks of a mast of 1 m in ten beams, and of others with known frequencies, as other programs write them."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

import tautflex as tf

ALUMINIUM = tf.Material(7e10, 2700.0, 0.33)
TUBE = tf.BeamSection(ALUMINIUM, 1e-4, 8.33e-10, 8.33e-10, 1.4e-9)
FILM = tf.MembraneSection(tf.Material(3.5e9, 1530.0, 0.34), 1e-4)
CLAMPED_FREE, CLAMPED_CLAMPED = 1.87510407**2, 4.73004074**2


def beam_frequency(factor: float, length: float = 1.0) -> float:
    """Frequency of an Euler-Bernoulli beam of the mast's section [Hz]: factor / (2 pi L^2) sqrt(EI / m)."""
    stiffness = ALUMINIUM.youngs_modulus * TUBE.inertia_y / (ALUMINIUM.density * TUBE.area)
    return factor / (2.0 * np.pi * length**2) * float(np.sqrt(stiffness))


def tip_mass_frequency(ratio: float) -> float:
    """Cantilever with a tip mass of ``ratio`` times its own: 1 + cos cosh + ratio b (cos sinh - sin cosh) = 0."""
    root = brentq(
        lambda b: 1 + np.cos(b) * np.cosh(b) + ratio * b * (np.cos(b) * np.sinh(b) - np.sin(b) * np.cosh(b)), 0.1, 1.8
    )
    return beam_frequency(root**2)


def frequencies(mesh: tf.MeshData, n: int = 2, **given: object) -> np.ndarray:
    """First frequencies of a mesh with the mast's section and film."""
    if len(mesh.triangles) + len(mesh.quads):
        given = {"membrane": FILM, "membrane_stress": (1e6, 1e6, 0.0), **given}
    if len(mesh.beams):
        given = {"beam": TUBE, **given}
    return tf.solve_modes(tf.solve_prestress(mesh.model(**given)), n=n).frequencies


GRIDS = "".join(f"GRID,{k + 1},,{k / 10},0.0,0.0\n" for k in range(11))
BARS = "".join(f"CBAR,{k},1,{k},{k + 1},0.,0.,1.\n" for k in range(1, 11))
HELD = "SPC1,1,123456,1\n"


PROPERTIES = "PBAR,1,1,1.0-4,8.33-10,8.33-10,1.4-9\nMAT1,1,7.+10,,.33,2700.\n"


def nastran(
    bulk: str = HELD,
    *,
    control: str = "SPC = 1\n",
    grids: str = GRIDS,
    bars: str = BARS,
    properties: str = PROPERTIES,
) -> str:
    """Mast as a deck."""
    return f"SOL 103\nCEND\n{control}BEGIN BULK\n{grids}{bars}{properties}EIGRL,1,,,4\n{bulk}ENDDATA\n"


NODES = "*Node\n" + "".join(f"{k + 1}, {k / 10}, 0., 0.\n" for k in range(11))
BEAMS = "*Element, type=B31\n" + "".join(f"{k}, {k}, {k + 1}\n" for k in range(1, 11))
SETS = "*Nset, nset=root\n1\n*Nset, nset=tip\n11\n*Elset, elset=outer, generate\n6, 10, 1\n"
MATERIAL = "*Material, name=al\n*Elastic\n7e10,0.33\n*Density\n2700.\n"
STEP = "*Step, perturbation\n*Frequency\n4\n*End Step\n"


def abaqus(model: str = "", boundary: str = "*Boundary\nroot, encastre\n", steps: str = STEP) -> str:
    """Mast as a flat input file."""
    return f"*Heading\n{NODES}{BEAMS}{SETS}{model}{MATERIAL}{boundary}{steps}"


def assembled(part: str, assembly: str, boundary: str) -> str:
    """Mast as a part with one instance, as Abaqus/CAE writes it."""
    section = "*Beam Section, elset=Set-1, material=al, section=RECT\n0.01,0.01\n0.,0.,1.\n"
    instance = f"*Instance, name=Mast-1, part=Mast\n*End Instance\n{assembly}"
    text = f"*Heading\n*Part, name=Mast\n{NODES}{BEAMS}{part}{section}*End Part\n*Assembly, name=Assembly\n{instance}"
    return f"{text}*End Assembly\n{MATERIAL}*Boundary\n{boundary}{STEP}"
