"""Arrays of compiled loops by their addresses: one argument in place of a hundred.

Handing a compiled function an array costs as much as a hundred flops of it, and a plant has a hundred arrays. A table
of their addresses and shapes is one array; compiled code makes the arrays of it again, without copying them.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import carray, types  # type: ignore[attr-defined]
from numba.core import cgutils
from numba.extending import intrinsic, overload

from tautflex.control.compiled.axis_parts import AxisModel, AxisSpace, AxisState
from tautflex.control.compiled.parts import Drives, LinearLoop, LoopState, Sensing
from tautflex.numeric import Indices
from tautflex.reduction.marching.free_hub.hub_arrays import HubArrays, HubInputs
from tautflex.reduction.marching.free_hub.hub_inertia import HubPlace
from tautflex.reduction.marching.free_hub.hub_work import HubWork
from tautflex.reduction.marching.work import Work
from tautflex.reduction.polynomial.forces import ReducedArrays

# Numbers of an array in a table: address and up to four lengths.
_WIDTH = 5
# Fields of each part in order: number of axes of an array, i and I: of indices with one and two, b: of truth values, s:
# a number, p: a place of the hub.
_NUMBERS: dict[str, type[Any]] = {"i": np.int64, "I": np.int64, "b": np.bool_}
FIELDS: dict[type, str] = {
    ReducedArrays: "ii22222244",
    HubArrays: "1iii2233223311s12",
    HubInputs: "222223",
    Work: "111112332211i",
    HubPlace: "2222111",
    HubWork: "1112211p22211121221",
    Drives: "111111iiii22222322i1",
    Sensing: "222221i323i1111i",
    LinearLoop: "2222112",
    LoopState: "32222233222233Ii3",
    AxisModel: "ii222222222212121222122222222212i",
    AxisState: "222222222222i",
    AxisSpace: "33222222222",
}


def table_of(*parts: Any) -> tuple[Indices, list[Any]]:
    """Table of parts in order, and the arrays that must live as long as it is used."""
    arrays = [array for part in parts for array in _arrays(part)]
    table = np.zeros((len(arrays), _WIDTH), dtype=np.int64)
    for row, array in zip(table, arrays, strict=True):
        row[0], row[1 : 1 + array.ndim] = array.ctypes.data, array.shape
    return table.ravel(), arrays


def _arrays(part: Any) -> list[Any]:
    """Arrays of a part in order; of a number an array of one."""
    found: list[Any] = []
    for field, value in zip(FIELDS[type(part)], part, strict=True):
        if field == "p":
            found += _arrays(value)
            continue
        kind = _NUMBERS.get(field, np.float64)
        array = np.atleast_1d(np.asarray(value, dtype=kind))
        assert array.flags.c_contiguous, type(part)
        assert array.ndim == _axes(field), (type(part), array.shape)
        found.append(array)
    return found


def _axes(field: str) -> int:
    return {"i": 1, "s": 1, "b": 1, "I": 2}.get(field) or int(field)


def width(kind: type) -> int:
    """Numbers of a part in a table."""
    return _WIDTH * sum(width(HubPlace) // _WIDTH if field == "p" else 1 for field in FIELDS[kind])


def _source(kind: type, at: int, known: dict[str, Any]) -> tuple[str, int]:
    """Source text that makes a part from place ``at`` of the table on, and the place behind it."""
    name, parts = kind.__name__, list[str]()
    known[name] = kind
    for field in FIELDS[kind]:
        if field == "p":
            text, at = _source(HubPlace, at, known)
            parts.append(text)
            continue
        lengths = "".join(f"table[first + {at + 1 + k}], " for k in range(_axes(field)))
        number = field if field in _NUMBERS else "number"
        text = f"carray(pointer(table[first + {at}]), ({lengths}), {number})"
        parts.append(f"{text}[0]" if field == "s" else text)
        at += _WIDTH
    return f"{name}({', '.join(parts)})", at


@intrinsic
def _pointer(typing: Any, address: Any) -> Any:
    """Address as a pointer."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(types.int64), generate


def part_at(kind: type[NamedTuple], table: Indices, first: int) -> Any:
    """Part of this kind whose numbers begin at a place of the table; in compiled code alone."""
    raise NotImplementedError


@overload(part_at)
def _part_at(kind: Any, table: Any, first: Any) -> Any:
    known: dict[str, Any] = {"carray": carray, "pointer": _pointer, "number": np.float64, **_NUMBERS}
    text, _ = _source(kind.instance_class, 0, known)
    exec(f"def made(kind: Any, table: Any, first: Any) -> Any:\n    return {text}\n", known)
    return known["made"]
