"""Arrays as text for a page: typed arrays of JavaScript in base64, at no more precision than a picture needs."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tautflex.numeric import Array

_LARGEST = 32767
# NaN of a quantised array.
_NOTHING = -32768


def packed(values: ArrayLike) -> dict[str, Any]:
    """Numbers in single precision; integers and truth values as the smallest unsigned ones that hold them."""
    given = np.asarray(values)
    if given.dtype.kind in "iub":
        largest = int(given.max(initial=0))
        kind = "uint8" if largest < 256 else "uint16" if largest < 65536 else "uint32"
    else:
        kind = "float32"
    return _written(given, kind)


def exact(values: ArrayLike) -> dict[str, Any]:
    """Numbers in double precision, as they are."""
    return _written(np.asarray(values), "float64")


def quantised(values: ArrayLike) -> dict[str, Any]:
    """Numbers as 16-bit integers times a scale of their last axis's entries: within 2e-5 of the largest; NaN kept."""
    given = np.asarray(values, dtype=np.float64)
    flat = given.reshape(-1, given.shape[-1])
    size = np.nanmax(np.abs(flat), axis=0, initial=0.0)
    scale = np.where(size > 0.0, size / _LARGEST, 1.0)
    whole = np.where(np.isnan(flat), _NOTHING, np.round(np.nan_to_num(flat) / scale))
    return _written(whole.reshape(given.shape), "int16") | {"scale": scale.tolist()}


def unpacked(written: Mapping[str, Any]) -> Array:
    """What a page reads of numbers that were written here, in double precision."""
    raw = np.frombuffer(base64.b64decode(written["base64"]), np.dtype(written["array"]).newbyteorder("<"))
    return raw.reshape(written["shape"]).astype(np.float64) * np.asarray(written.get("scale", 1.0))


def _written(values: np.ndarray, kind: str) -> dict[str, Any]:
    raw = np.ascontiguousarray(values, dtype=np.dtype(kind).newbyteorder("<"))
    return {"array": kind, "shape": list(values.shape), "base64": base64.b64encode(raw.tobytes()).decode("ascii")}


def plain(value: Any) -> Any:
    """Nested values as JSON has them: numbers that are not finite become null."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
