"""Writers of small mesh files for tests: exact numbers, only what the readers need."""

from __future__ import annotations

import subprocess
import sys
from functools import cache

import numpy as np

from tautflex import Model

HELD = "123456"


@cache
def gmsh_starts() -> bool:
    """Whether Gmsh, of the extra tautflex[mesh], is installed and finds the libraries of the system it needs."""
    return subprocess.run([sys.executable, "-c", "import gmsh"], capture_output=True, check=False).returncode == 0


def held_nodes(model: Model) -> list[int]:
    """Nodes of all supports."""
    return sorted({node for support in model.supports for node in support.nodes})


def msh(model: Model) -> str:
    """Gmsh 2.2 text: physical groups membrane, cables_x, cables_y, frame, support."""
    names = [(2, 1, "membrane"), (1, 2, "cables_x"), (1, 3, "cables_y"), (1, 4, "frame"), (0, 5, "support")]
    elements = [(2, 1, nodes) for nodes in model.triangles]
    elements += [(1, 2 if along else 3, nodes) for along, nodes in zip(along_x(model), model.cables, strict=True)]
    elements += [(1, 4, nodes) for nodes in model.beams] + [(15, 5, [node]) for node in held_nodes(model)]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names))]
    lines += [f'{dimension} {tag} "{name}"' for dimension, tag, name in names]
    lines += ["$EndPhysicalNames", "$Nodes", str(len(model.nodes))]
    lines += [f"{k} {x!r} {y!r} {z!r}" for k, (x, y, z) in enumerate(model.nodes.tolist(), start=1)]
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    for number, (kind, group, nodes) in enumerate(elements, start=1):
        entity = group if kind != 15 else 10 + number
        lines.append(f"{number} {kind} 2 {group} {entity} " + " ".join(str(node + 1) for node in nodes))
    return "\n".join([*lines, "$EndElements", ""])


def abaqus(model: Model) -> str:
    """Abaqus input: sets FILM, CABLES-X, CABLES-Y, FRAME; the held nodes by GENERATE, list and *BOUNDARY."""
    lines = ["*HEADING", "an antenna", "** comment", "*NODE, NSET=ALL"]
    lines += [f"{k}, {x!r}, {y!r}, {z!r}" for k, (x, y, z) in enumerate(model.nodes.tolist(), start=1)]
    number = 0
    chosen = along_x(model)
    for name, kind, elements in (
        ("FILM", "M3D3", model.triangles),
        ("CABLES-X", "T3D2", model.cables[chosen]),
        ("CABLES-Y", "T3D2", model.cables[~chosen]),
        ("FRAME", "B31", model.beams),
    ):
        lines.append(f"*Element, type={kind},\n elset={name}")
        for nodes in elements + 1:
            number += 1
            lines.append(f"{number}, " + ", ".join(map(str, nodes)))
    first, *rest = (node + 1 for node in held_nodes(model))
    lines += ["*NSET, NSET=corner, GENERATE", f"{first}, {first}, 1", "*NSET, NSET=Held", "corner"]
    lines += [f"{node}," for node in rest]
    lines += ["*MATERIAL, NAME=FILM", "*ELASTIC", "3.5e9, 0.34", "*BOUNDARY", "Held, 1, 6", "*STEP", "*END STEP", ""]
    return "\n".join(lines)


def nastran(model: Model) -> str:
    """Nastran bulk data in large, free and small fields; properties 1 film, 2 and 3 cables, 4 frame."""
    lines = ["SOL 103", "CEND", "SPC = 1", "BEGIN BULK", "$ an antenna"]
    for k, position in enumerate(model.nodes.tolist(), start=1):
        x, y, z = (f"{value:.17g}" for value in position)
        lines.append(f"GRID,{k},,{x},{y},{z}" if k % 2 else f"GRID*,{k},,{x},{y}\n*,{z}")
    number = 0
    chosen = along_x(model)
    for name, group, elements in (
        ("CTRIA3", 1, model.triangles),
        ("CROD", 2, model.cables[chosen]),
        ("CROD", 3, model.cables[~chosen]),
        ("CBAR", 4, model.beams),
    ):
        for nodes in elements + 1:
            number += 1
            lines.append(f"{name:<8}{number:>8}{group:>8}" + "".join(f"{node:>8}" for node in nodes))
    lines.append(f"SPC1,1,{HELD}," + ",".join(str(node + 1) for node in held_nodes(model)))
    return "\n".join([*lines, "PSHELL,1,1,1.-4", "ENDDATA", ""])


def along_x(model: Model) -> np.ndarray:
    """Whether each cable runs along x."""
    ends = model.nodes[model.cables]
    step = np.abs(ends[:, 1] - ends[:, 0])
    return step[:, 0] > step[:, 1]
