"""Gmsh meshes (.msh, formats 2 and 4, text or binary), read by Gmsh itself in a process of its own.

Gmsh would run a text without mesh header as a script with shell access, and reads option files that lie beside a
mesh. So only files with the header of a mesh are given to it, under a fixed name in a folder of their own. Gmsh is
under the GPL and may crash: the process of its own keeps both from this one.
"""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tautflex.errors import MeshError, MissingExtraError
from tautflex.files.mesh.gmsh._gmsh_worker import NO_GMSH, REFUSED
from tautflex.files.mesh.raw import Numbering, RawGroup, RawMesh, require_coordinates, shorten
from tautflex.files.mesh.second_order import WIDTHS, simplified
from tautflex.numeric import Indices

SECONDS = 120
# Address space Gmsh may take; measured on meshes of 120 000 triangles: 0.2 GB, and 8 bytes for each byte of the file.
_BASE_BYTES = 2**30
_BYTES_PER_BYTE = 50
_HEADER = re.compile(rb"\$MeshFormat[ \t]*\r?\n[ \t]*([24])(\.\d{1,3})?[ \t]+[01][ \t]+\d{1,2}[ \t]*\r?\n")

UNGROUPED = "ungrouped"
"""Group of the surfaces that no physical group has."""
_EXPECTED = "expected triangles of 3 or 6 nodes, quadrilaterals of 4, 8 or 9"

INSTALL = "pip install 'tautflex[mesh]'"
LIBRARIES = "libglu1-mesa libgl1 libxrender1 libxcursor1 libxft2 libxinerama1 libgomp1"


def read_gmsh(content: bytes, seconds: int = SECONDS) -> RawMesh:
    """Read the mesh and the physical groups of a Gmsh file; it is given up after some ``seconds``.

    Raises
    ------
    MissingExtraError
        If Gmsh is not installed, or cannot start because the system lacks its libraries.
    MeshError
        If the file is no mesh of format 2 or 4, or Gmsh refuses, crashes on it, or takes too long.
    """
    if _HEADER.match(content) is None:
        raise MeshError(
            "expected a Gmsh mesh of format 2 or 4 ($MeshFormat, then the version); save it with Gmsh again"
        )
    if importlib.util.find_spec("gmsh") is None:
        raise MissingExtraError(f"reading .msh files needs Gmsh, which is not installed; {INSTALL}")
    with tempfile.TemporaryDirectory(prefix="tautflex-") as folder:
        mesh, arrays = Path(folder, "mesh.msh"), Path(folder, "arrays.npz")
        mesh.write_bytes(content)
        _run_worker(mesh, arrays, _BASE_BYTES + _BYTES_PER_BYTE * len(content), seconds)
        return _raw_mesh(_loaded(arrays))


def _run_worker(mesh: Path, arrays: Path, most_bytes: int, seconds: int) -> None:
    script = Path(__file__).with_name("_gmsh_worker.py")
    command = [sys.executable, "-P", str(script), mesh.name, arrays.name, str(most_bytes), str(seconds)]
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    try:
        done = subprocess.run(
            command,
            cwd=mesh.parent,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            timeout=seconds,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise MeshError(f"expected a mesh that Gmsh reads within {seconds} s, got none; is the file damaged?") from None
    last = done.stderr[-2000:].decode("utf-8", "replace").strip().splitlines()
    said = shorten(last[-1], 200) if last else "nothing"
    if done.returncode == NO_GMSH:
        raise MissingExtraError(
            f"reading .msh files needs Gmsh, which cannot start: {said}; {INSTALL}, and install the system libraries "
            f"it draws with (Debian, Ubuntu: apt install {LIBRARIES})"
        )
    if done.returncode == REFUSED:
        raise MeshError(f"Gmsh refuses the file: {said}; save it with Gmsh again")
    if done.returncode != 0:
        raise MeshError(f"Gmsh broke off on the file (status {done.returncode}, last words {said}); is it damaged?")


def _loaded(path: Path) -> dict[str, NDArray[Any]]:
    """Arrays of the worker, checked like any foreign data."""
    try:
        with np.load(path, allow_pickle=False) as stored:
            return {name: stored[name] for name in stored.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise MeshError(f"Gmsh read the file but its arrays cannot be ({error}); is the disk full?") from None


def _raw_mesh(arrays: dict[str, NDArray[Any]]) -> RawMesh:
    for count, values in [("node_numbers", "nodes"), *((f"{shape}_numbers", shape) for shape in WIDTHS)]:
        order = np.argsort(arrays[count], kind="stable")  # Gmsh keeps them by entity, its users by number
        arrays[count], arrays[values] = arrays[count][order], arrays[values][order]
    require_coordinates(arrays["nodes"], arrays["node_numbers"])
    if len(arrays["other_surfaces"]):
        raise MeshError(f"{_EXPECTED}, got {', '.join(arrays['other_surfaces'])}; mesh with order 1 or 2")
    nodes = Numbering("node", arrays["node_numbers"])
    # format 2 repeats an element for every group it is in: keep one, let all numbers point to it
    unique, rows, numbers = {}, {}, {}
    for shape in WIDTHS:
        unique[shape], rows[shape] = _without_copies(nodes.rows(arrays[shape], shape))
        numbers[shape] = arrays[f"{shape}_numbers"]
    groups, start = [], 0
    for name, dimension, size, others in zip(
        arrays["group_names"], arrays["group_dimensions"], arrays["group_sizes"], arrays["group_others"], strict=True
    ):
        members = arrays["group_members"][start : start + size]
        start += size
        if others and dimension > 0:
            raise MeshError(
                f"group {shorten(name)}: {_EXPECTED}, or lines of 2 or 3, got {others}; mesh with order 1 or 2, and "
                "give volumes no physical group"
            )
        if dimension == 0:
            found = {"nodes": np.unique(nodes.rows(members, str(name)))}
        else:
            found = {shape: np.unique(rows[shape][np.isin(numbers[shape], members)]) for shape in WIDTHS}
        groups.append(RawGroup(str(name), found))
    rest = _ungrouped(unique, groups)
    roles = {shape: np.full(len(own), "", dtype="<U8") for shape, own in unique.items()}
    lines = len(unique["line2"]) + len(unique["line3"])
    return simplified(arrays["nodes"], unique, roles, np.full((lines, 3), np.nan), [*groups, *rest], typed=False)


def _ungrouped(elements: dict[str, Indices], groups: list[RawGroup]) -> list[RawGroup]:
    """Group of the surfaces that are in none although others are: left out they would be holes."""
    surfaces = [shape for shape in WIDTHS if not shape.startswith("line")]
    if not any(len(group.of(shape)) for group in groups for shape in surfaces):
        return []
    rest = {
        shape: np.setdiff1d(np.arange(len(elements[shape])), np.concatenate([group.of(shape) for group in groups]))
        for shape in surfaces
    }
    return [RawGroup(UNGROUPED, rest)] if any(len(rows) for rows in rest.values()) else []


def _without_copies(connectivity: Indices) -> tuple[Indices, Indices]:
    """Elements in their order without repetitions, and the new row of each old one."""
    _, first, inverse = np.unique(np.sort(connectivity, axis=1), axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return connectivity[first[order]], place[inverse.ravel()].astype(np.int64)
