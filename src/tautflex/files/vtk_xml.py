"""VTK XML files: an unstructured grid per instant (.vtu) and the collection that lists them (.pvd).

Numbers are stored in base64 behind their length in bytes, as VTK's "binary" format asks, in the byte order of the
machine, which the file states. ParaView, VisIt and PyVista open both.
"""

from __future__ import annotations

import base64
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

LINE, TRIANGLE = 3, 5  # VTK's numbers of cell types
_TYPES = {"f8": "Float64", "f4": "Float32", "i8": "Int64", "i4": "Int32", "u1": "UInt8"}


@dataclass(frozen=True)
class Cells:
    """Cells of a grid.

    Parameters
    ----------
    connectivity
        Point numbers of all cells, one after another.
    offsets
        End of each cell in ``connectivity``, shape (cell,).
    types
        VTK cell type of each, shape (cell,).
    """

    connectivity: NDArray[np.int64]
    offsets: NDArray[np.int64]
    types: NDArray[np.uint8]


def join_cells(triangles: NDArray[np.int64], *lines: NDArray[np.int64]) -> Cells:
    """Cells of triangles, shape (t, 3), followed by sets of lines, shapes (l, 2)."""
    sizes = np.concatenate([np.full(len(part), part.shape[1], dtype=np.int64) for part in (triangles, *lines)])
    types = np.where(sizes == 3, TRIANGLE, LINE).astype(np.uint8)
    connectivity = np.concatenate([part.ravel() for part in (triangles, *lines)]).astype(np.int64)
    return Cells(connectivity, np.cumsum(sizes), types)


def write_grid(
    path: Path,
    points: NDArray[np.float64],
    cells: Cells,
    point_data: Mapping[str, NDArray[np.generic]],
    cell_data: Mapping[str, NDArray[np.generic]],
) -> None:
    """Write one grid.

    Parameters
    ----------
    path
        File, ``*.vtu``.
    points
        Positions [m], shape (point, 3).
    cells
        Cells.
    point_data, cell_data
        Fields by name, shapes (point,) or (point, component), and the same for cells.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    with path.open("w", encoding="ascii", errors="xmlcharrefreplace", newline="\n") as file:
        file.write(_head("UnstructuredGrid") + "<UnstructuredGrid>\n")
        file.write(f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(cells.types)}">\n')
        file.write("<Points>\n" + _array("Points", points) + "</Points>\n<Cells>\n")
        for name in ("connectivity", "offsets", "types"):
            file.write(_array(name, getattr(cells, name)))
        file.write("</Cells>\n")
        for section, fields in (("PointData", point_data), ("CellData", cell_data)):
            file.write(f"<{section}>\n" + "".join(_array(name, values) for name, values in fields.items()))
            file.write(f"</{section}>\n")
        file.write("</Piece>\n</UnstructuredGrid>\n</VTKFile>\n")


def write_collection(path: Path, files: Sequence[str], times: Sequence[float]) -> None:
    """Write the list of a series: files relative to ``path`` and their times [s].

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    rows = (
        f'<DataSet timestep="{float(time)!r}" part="0" file={quoteattr(file)}/>\n'
        for file, time in zip(files, times, strict=True)
    )
    text = _head("Collection") + "<Collection>\n" + "".join(rows) + "</Collection>\n</VTKFile>\n"
    path.write_text(text, encoding="utf-8", newline="\n")


def _head(kind: str) -> str:
    order = "LittleEndian" if sys.byteorder == "little" else "BigEndian"
    attributes = f'type="{kind}" version="1.0" byte_order="{order}" header_type="UInt64"'
    return f'<?xml version="1.0" encoding="UTF-8"?>\n<VTKFile {attributes}>\n'


def _array(name: str, values: NDArray[np.generic]) -> str:
    numbers = np.ascontiguousarray(values)
    if numbers.dtype.kind == "b":
        numbers = numbers.astype(np.uint8)
    kind = _TYPES.get(numbers.dtype.str[1:])
    if kind is None:
        numbers, kind = numbers.astype(np.float64), "Float64"
    components = numbers.shape[1] if numbers.ndim == 2 else 1
    raw = numbers.tobytes()
    text = base64.b64encode(len(raw).to_bytes(8, sys.byteorder) + raw).decode("ascii")
    shape = f'NumberOfComponents="{components}"' if numbers.ndim == 2 else ""
    return f'<DataArray type="{kind}" Name={quoteattr(name)} {shape} format="binary">{text}</DataArray>\n'
