"""`read_mesh`: one call for every format."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from importlib import import_module

from tautflex import checks
from tautflex.errors import MeshError
from tautflex.files.content import read_bytes
from tautflex.files.mesh.assembly import assemble
from tautflex.files.mesh.include import LARGEST_FILE, Folder, decoded
from tautflex.files.mesh.mesh_data import MeshData
from tautflex.files.mesh.raw import RawMesh, shorten

_TEXT = {
    ".inp": "files.mesh.abaqus:read_abaqus",
    **dict.fromkeys((".bdf", ".nas", ".dat"), "files.mesh.nastran:read_nastran"),
}
READERS = {".msh": "files.mesh.gmsh:read_gmsh", **_TEXT}
"""Function that reads each format, imported when it is needed."""


def _raw(content: bytes, suffix: str, folder: Folder, step: int | None) -> RawMesh:
    module, _, name = READERS[suffix].partition(":")
    reader: Callable[..., RawMesh] = getattr(import_module(f"tautflex.{module}"), name)
    if suffix in _TEXT:
        return reader(decoded(content), folder, step)
    if step is not None:
        raise MeshError(f"expected no step of a Gmsh mesh, which has none, got {step}; remove it")
    return reader(content)


def read_mesh(
    path: str | os.PathLike[str],
    names: Mapping[str, str] | None = None,
    *,
    unit_length: float = 1.0,
    unit_mass: float | None = None,
    step: int | None = None,
) -> MeshData:
    """Read a mesh of Gmsh (``.msh``), Abaqus (``.inp``) or Nastran (``.bdf``, ``.nas``, ``.dat``).

    Groups are understood by their names: one that begins with ``membrane`` or ``film``, ``cable``, ``beam`` or
    ``frame`` holds elements of that kind; ``support``, ``clamped`` or ``fixed`` nodes held in all six directions,
    ``pinned`` nodes held in three; ``ignore`` what shall be left out. Gmsh: physical groups, of any dimension for
    supports; surfaces in a file without named surfaces are the membrane. Abaqus and Nastran: element types decide
    (M3D3, M3D4, CTRIA3, CQUAD4: membrane; T3D2, CROD: cable; B31, B33, CBAR, CBEAM: beam), names of sets only about
    supports, beside ``*BOUNDARY``, ``SPC`` and ``SPC1``, and about shells (S3, S4), which are membranes only when
    named so. What a reader does not know, and what would change the structure if left out, is refused.

    Parameters
    ----------
    path
        The file; its suffix states the format.
    names
        Roles that the names do not tell, ``{"group": "cable"}``: ``"membrane"``, ``"cable"``, ``"beam"``,
        ``"clamped"`` (or ``"support"``), ``"pinned"`` or ``"ignore"``. They come before everything else. Nastran
        properties and constraints are the groups ``pid<N>`` and ``spc<N>``.
    unit_length
        Length of the file's unit [m], 0.001 for a mesh in millimetres.
    unit_mass
        Mass of the file's unit [kg], needed where ``unit_length`` is given and the file has point masses, moduli or
        densities: 1000 for tonnes. Seconds are the unit of time.
    step
        Step (Abaqus) or subcase (Nastran) whose supports hold, from 1. None takes the only one, the only one that asks
        for frequencies, or any if all have the same supports.

    Returns
    -------
    MeshData

    Raises
    ------
    MeshError
        If the file cannot be read, is damaged, or holds what is not read here; the message names the file.
    MissingExtraError
        If a ``.msh`` file is given and Gmsh is not installed.

    Examples
    --------
    >>> import tautflex as tf
    >>> mesh = tf.read_mesh("sail.inp")
    >>> sorted(mesh.groups)
    ['beams-boom', 'cables-edge', 'film', 'support-hub']
    """
    source = checks.path("path", path)
    shown = shorten(str(source), 200).strip("'\"")
    checks.positive("unit_length", unit_length)
    if unit_mass is not None:
        checks.positive("unit_mass", unit_mass)
    if step is not None:
        checks.whole("step", step, 1)
    suffix = source.suffix.lower()
    if suffix not in READERS:
        raise MeshError(f"{shown}: expected a mesh named {', '.join(READERS)}, got {shorten(source.suffix)}; rename it")
    content = read_bytes(source, shown, "mesh", LARGEST_FILE, "check its path", MeshError)
    try:
        return assemble(_raw(content, suffix, Folder(source), step), names, unit_length, unit_mass)
    except MeshError as error:
        raise error.behind(f"{shown}: ") from None
