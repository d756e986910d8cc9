"""Stored fields for ParaView, VisIt and PyVista: an unstructured grid per instant (.vtu), listed in a series (.pvd)."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TypeAlias
from xml.sax.saxutils import escape, quoteattr

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from pyevtk.vtk import VtkFile, VtkUnstructuredGrid, np_to_vtk

from tautflex import checks
from tautflex.errors import InputError
from tautflex.files.results import results_of_a_run
from tautflex.numeric import Array, Indices
from tautflex.solvers.variables import MESH, dataset_of
from tautflex.writing import written_together

Fields: TypeAlias = Mapping[str, NDArray[np.generic]]
Cells: TypeAlias = tuple[Indices, int]
"""Point numbers of like cells, shape (cell, point), and VTK's number of their type."""

# Kinds of cells and VTK's number of their type, in the order in which they are written; the cell field "kind" counts
# them in this order.
CELL_TYPES = {"triangle": 5, "cable": 3, "beam": 3}
_LINK = {"link": 3}
_SERIES = ("field_time", "mode")


@results_of_a_run()
def write_vtu(dataset: xr.Dataset, directory: str | os.PathLike[str], name: str = "run") -> list[Path]:
    """Write the stored fields of a run, or mode shapes, for ParaView.

    Points stand in the reference position; ParaView's filter "Warp By Vector" moves them by ``displacement``.
    Every variable over the nodes becomes point data, every one over the film's elements, cables or beams cell data
    (NaN, or -1 for integers, on cells of the other kinds); ``kind`` tells film 0, cables 1, beams 2 and links 3 apart.
    The film is written as the elements it has, quadratic triangles as such. Mode shapes are a series over the mode's
    number.

    Parameters
    ----------
    dataset
        ``run.data`` with stored fields, or ``modes.to_dataset()``.
    directory
        Where ``<name>.pvd`` and the folder ``<name>_vtu`` go; created if missing.
    name
        Stem of the files.

    Returns
    -------
    list of pathlib.Path
        The PVD file, then the VTU files in time.

    Raises
    ------
    InputError
        If the dataset holds no fields or no mesh.
    NotWrittenError
        If the files cannot be written; what stood there is whole.

    Examples
    --------
    >>> import tautflex as tf
    >>> run = tf.load_run("m2/run.nc")
    >>> files = tf.write_vtu(run.data, "fields")
    >>> files[0].name
    'run.pvd'
    """
    dataset = dataset_of("dataset", dataset, "node_position", *CELL_TYPES, remedy="give run.data or modes.to_dataset()")
    directory = checks.path("directory", directory)
    if not checks.instance("name", name, str, "the stem of a file").strip() or {"/", "\\", "\0"} & set(name):
        raise InputError(f"name: expected the stem of a file, got {name!r}; folders go into directory")
    series = _require_fields(dataset)
    steps = dataset[series].values
    points = checks.float_array("node_position", dataset["node_position"].values, (None, 3))
    types = CELL_TYPES | (_LINK if "link" in dataset else {})
    parts = [_cells_of(dataset, kind, len(points)) for kind in types]
    cells = [group for part in parts for group in part]
    counts = [sum(len(corners) for corners, _ in part) for part in parts]
    kinds = np.repeat(np.arange(len(parts), dtype=np.int32), counts)
    owners = {str(dataset[kind].dims[0]): place for place, kind in enumerate(types)}
    if "membrane" in dataset:
        owners[str(dataset["membrane"].dims[0])] = 0
        # What is known of an element's triangles is the same for all of them: keep the first of each.
        first = np.unique(dataset["triangle_owner"].values, return_index=True)[1]
        dataset = dataset.drop_vars("triangle").isel({str(dataset["triangle"].dims[0]): first})
    files = [f"{name}_vtu/{name}_{step:0{max(4, len(str(len(steps))))}d}.vtu" for step in range(len(steps))]
    with written_together(directory) as place:
        (place / f"{name}_vtu").mkdir()
        for step, file in enumerate(files):
            instant = dataset.isel({series: step})
            of_cells = dict(_cell_fields(instant, owners, counts))
            write_grid(place / file, points, cells, dict(_point_fields(instant)), {"kind": kinds} | of_cells)
        _write_collection(place / f"{name}.pvd", files, [float(step) for step in steps])
    return [directory / f"{name}.pvd", *(directory / file for file in files)]


def _cells_of(dataset: xr.Dataset, kind: str, points: int) -> list[Cells]:
    """Groups of like cells of one kind, in the order of its elements."""
    if kind != "triangle" or "membrane" not in dataset:
        corners = 3 if kind == "triangle" else 2
        return [(checks.index_array(kind, dataset[kind].values, corners, points), (CELL_TYPES | _LINK)[kind])]
    types = dataset["membrane_cell"].values
    cuts = np.flatnonzero(np.diff(types)) + 1
    rows = np.split(dataset["membrane"].values, cuts)
    groups = [(nodes[:, nodes[0] >= 0], int(own[0])) for nodes, own in zip(rows, np.split(types, cuts), strict=True)]
    return [(checks.index_array("membrane", nodes, nodes.shape[1], points), cell) for nodes, cell in groups]


def write_grid(path: Path, points: Array, cells: Sequence[Cells], point_data: Fields, cell_data: Fields) -> None:
    """Write one grid: point data of shape (point,) or (point, component), cell data in the order of the groups."""
    sizes = np.concatenate([np.full(len(corners), corners.shape[1], dtype=np.int64) for corners, _ in cells])
    topology = {
        "connectivity": np.concatenate([corners.ravel() for corners, _ in cells]),
        "offsets": np.cumsum(sizes),
        "types": np.concatenate([np.full(len(corners), number, dtype=np.uint8) for corners, number in cells]),
    }
    sections = {"Points": {"points": points}, "Cells": topology, "PointData": point_data, "CellData": cell_data}
    tables = {tag: {name: _storable(values) for name, values in fields.items()} for tag, fields in sections.items()}
    # pyevtk's functions of a higher level know scalars and triples only; headers take any number of components.
    file = VtkFile(str(path.with_suffix("")), VtkUnstructuredGrid)
    file.openGrid()
    file.openPiece(npoints=len(points), ncells=len(sizes))
    for tag, fields in tables.items():
        file.openElement(tag)
        for name, values in fields.items():
            components = values.shape[1] if values.ndim == 2 else 1
            file.addHeader(escape(name, {'"': "&quot;"}), values.dtype.name, len(values), components)
        file.closeElement(tag)
    file.closePiece()
    file.closeGrid()
    for fields in tables.values():
        for values in fields.values():
            file.appendData(values.ravel())
    file.save()


def _write_collection(path: Path, files: Sequence[str], times: Sequence[float]) -> None:
    """List files, relative to ``path``, with their times [s]; pyevtk's own writer does not escape names."""
    rows = "".join(
        f'<DataSet timestep="{time!r}" part="0" file={quoteattr(file)}/>\n'
        for file, time in zip(files, times, strict=True)
    )
    text = f'<VTKFile type="Collection" version="1.0">\n<Collection>\n{rows}</Collection>\n</VTKFile>\n'
    path.write_text(text, encoding="utf-8", newline="\n")


def _storable(values: NDArray[np.generic]) -> NDArray[np.generic]:
    """The same numbers in a type that VTK has."""
    if values.dtype.kind == "b":
        return values.astype(np.uint8)
    return values if values.dtype.name in np_to_vtk else values.astype(np.float64)


def _require_fields(dataset: xr.Dataset) -> str:
    """Dimension of the series, or InputError."""
    series = next((dim for dim in _SERIES if dim in dataset.dims), None)
    if series is None or not dataset.sizes[series]:
        raise InputError(
            'dataset: expected stored fields, got none; run again with output.fields = "all" or a list of instants'
        )
    return series


def _point_fields(instant: xr.Dataset) -> Iterator[tuple[str, NDArray[np.generic]]]:
    for name, values in instant.data_vars.items():
        if name != "node_position" and values.dims[:1] == ("node",) and values.ndim <= 2 and _numeric(values):
            yield str(name), values.values


def _cell_fields(
    instant: xr.Dataset, owners: dict[str, int], counts: list[int]
) -> Iterator[tuple[str, NDArray[np.generic]]]:
    start = np.concatenate([[0], np.cumsum(counts)])
    for name, values in instant.data_vars.items():
        place = owners.get(str(values.dims[0])) if values.dims else None
        if place is None or name in MESH or values.ndim > 2 or not _numeric(values):
            continue
        own = values.values
        whole = own.dtype.kind in "iu"
        filled = np.full((start[-1], *own.shape[1:]), -1 if whole else np.nan, dtype=np.int64 if whole else float)
        filled[start[place] : start[place + 1]] = own
        yield str(name), filled


def _numeric(values: xr.DataArray) -> bool:
    return values.dtype.kind in "biuf"
