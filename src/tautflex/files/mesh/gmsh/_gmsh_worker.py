"""Child process that lets Gmsh read one .msh file and hands its arrays back.

Run as a script: ``python _gmsh_worker.py MESH.msh ARRAYS.npz BYTES SECONDS``. Gmsh is a large C++ program that may
crash, hang or ask for all memory on a damaged file; here that ends this process only, within the limits given. The
script stands alone: it imports Gmsh and NumPy, nothing of tautflex, and writes no pickles.

Exit status: 0 done, 3 Gmsh cannot be imported, 4 Gmsh refuses the file; a sentence about it goes to stderr.
"""

from __future__ import annotations

import sys
from contextlib import suppress
from typing import Any

NO_GMSH, REFUSED = 3, 4
POINT = 15
LINES = {"line2": (1, 2), "line3": (8, 3)}  # Gmsh's type and number of nodes
SURFACES = {"triangle3": (2, 3), "triangle6": (9, 6), "quad4": (3, 4), "quad8": (16, 8), "quad9": (10, 9)}
OWN = ((POINT,), tuple(k for k, _ in LINES.values()), tuple(k for k, _ in SURFACES.values()), ())  # by dimension


def main(mesh: str, target: str, most_bytes: int, most_seconds: int) -> int:
    """Read ``mesh``, write ``target``; return the exit status."""
    limit(most_bytes, most_seconds)
    try:
        import gmsh
        import numpy as np
    except (ImportError, OSError) as error:
        sys.stderr.write(f"{error}\n")
        return NO_GMSH
    try:
        gmsh.initialize([], readConfigFiles=False, run=False, interruptible=False)
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        gmsh.merge(mesh)
        arrays = collect(gmsh, np)
    except Exception as error:  # Gmsh raises nothing more precise
        sys.stderr.write(f"{error}\n")
        return REFUSED
    np.savez(target, **arrays)
    return 0


def limit(most_bytes: int, most_seconds: int) -> None:
    """Bound memory, time and files of this process where the system can."""
    with suppress(ImportError, OSError, ValueError):
        import resource

        for kind, value in (
            (resource.RLIMIT_AS, most_bytes),
            (resource.RLIMIT_CPU, most_seconds),
            (resource.RLIMIT_CORE, 0),
            (resource.RLIMIT_FSIZE, most_bytes),
        ):
            _, hard = resource.getrlimit(kind)
            wanted = value if hard == resource.RLIM_INFINITY else min(value, hard)
            resource.setrlimit(kind, (wanted, hard))


def collect(gmsh: Any, np: Any) -> dict[str, Any]:
    """Nodes, lines, surface elements and physical groups of the current model as arrays.

    Groups come as their names, and for each a slice of one array of element numbers (node numbers for groups of
    points). Elements of other types are named by group, and the surfaces among them for the whole file.
    """
    numbers, positions, _ = gmsh.model.mesh.getNodes(includeBoundary=False, returnParametricCoord=False)
    arrays = {"node_numbers": numbers.astype(np.int64), "nodes": positions.reshape(-1, 3)}
    for name, (kind, count) in {**LINES, **SURFACES}.items():
        tags, ends = gmsh.model.mesh.getElementsByType(kind)
        arrays[f"{name}_numbers"] = tags.astype(np.int64)
        arrays[name] = ends.astype(np.int64).reshape(-1, count)
    kinds = [kind for kind in gmsh.model.mesh.getElementTypes(2) if kind not in OWN[2]]
    arrays["other_surfaces"] = np.array(
        [gmsh.model.mesh.getElementProperties(kind)[0] for kind in kinds], dtype=np.str_
    )
    names, dimensions, members, others = [], [], [], []
    for dimension, tag in gmsh.model.getPhysicalGroups():
        names.append(
            gmsh.model.getPhysicalName(dimension, tag) or f"{('point', 'curve', 'surface', 'volume')[dimension]}{tag}"
        )
        dimensions.append(dimension)
        found, foreign = group_members(gmsh, np, dimension, tag)
        members.append(found)
        others.append(foreign)
    arrays["group_names"] = np.array(names, dtype=np.str_)
    arrays["group_dimensions"] = np.array(dimensions, dtype=np.int64)
    arrays["group_sizes"] = np.array([len(found) for found in members], dtype=np.int64)
    arrays["group_members"] = np.concatenate([np.zeros(0, dtype=np.int64), *members])
    arrays["group_others"] = np.array(others, dtype=np.str_)
    return arrays


def group_members(gmsh: Any, np: Any, dimension: int, tag: int) -> tuple[Any, str]:
    """Element (or node) numbers of one physical group, and the names of element types that are not read."""
    members, foreign = [np.zeros(0, dtype=np.int64)], set()
    for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, tag):
        kinds, tags, nodes = gmsh.model.mesh.getElements(dimension, entity)
        for kind, numbers, ends in zip(kinds, tags, nodes, strict=True):
            if kind in OWN[dimension]:
                members.append((ends if dimension == 0 else numbers).astype(np.int64))
            else:
                foreign.add(str(gmsh.model.mesh.getElementProperties(kind)[0]))
    return np.concatenate(members), ", ".join(sorted(foreign))


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])))
