"""Modal assurance criterion between sets of shapes, and its ranked table [paper, eq. (54), Table 3]."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from tautflex.checks import numbers, whole
from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.solvers.variables import MAC, dataset_of, described


def mac(a: xr.DataArray | ArrayLike, b: xr.DataArray | ArrayLike) -> Array:
    """Return the modal assurance criterion of every shape of ``a`` with every shape of ``b``.

    ``|p^T q|^2 / (p^T p  q^T q)`` [paper, eq. (54)]: 1 for shapes that differ only by a factor, 0 for
    orthogonal ones.

    Parameters
    ----------
    a, b
        Shapes (n, dof), (n, node, 3), or a single shape (dof,) or (node, 3) as DataArray or array. A
        DataArray counts its dimension ``mode`` as n. An array with two axes is read as (n, dof) unless it
        is (node, 3) and the other argument has three axes.

    Returns
    -------
    ndarray (n_a, n_b)
        Values in [0, 1].

    Raises
    ------
    InputError
        If the shapes do not have the same number of entries, are not finite, or one of them is zero.

    Examples
    --------
    >>> import numpy as np
    >>> import tautflex as tf
    >>> tf.mac(np.eye(2), np.eye(2)).tolist()
    [[1.0, 0.0], [0.0, 1.0]]
    """
    nodal = 3 in (numbers("a", a).ndim, numbers("b", b).ndim)
    first, second = _rows("a", a, nodal), _rows("b", b, nodal)
    if first.shape[1] != second.shape[1]:
        raise InputError(
            f"b: expected shapes of {first.shape[1]} entries like those of a, got {second.shape[1]}; "
            "compare shapes on the same nodes and components"
        )
    return np.asarray(np.clip((first @ second.T) ** 2, 0.0, 1.0), dtype=np.float64)


def mac_table(shape: xr.DataArray | ArrayLike, modes: xr.Dataset, count: int = 5) -> xr.Dataset:
    """Rank the normal modes by their similarity with one shape [paper, Table 3].

    Parameters
    ----------
    shape
        One shape (node, 3), e.g. the dominant shape of a run.
    modes
        Dataset of modes with ``shape(mode, node, component)``.
    count
        Number of modes to list.

    Returns
    -------
    xarray.Dataset
        Over ``rank`` = 1..count: ``mode`` (number), ``mac``, ``cumulative`` (sum of ``mac`` so far, at most
        1 if the shapes are orthogonal) and, where ``modes`` has it, ``frequency`` [Hz].

    Raises
    ------
    InputError
        If ``modes`` has no shapes, ``count`` is below 1, or the shapes do not fit together.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> modes = tf.solve_modes(state, n=4).to_dataset()
    >>> tf.mac_table(modes.shape.sel(mode=3), modes, count=2).mode.values.tolist()
    [3, 1]
    """
    modes = dataset_of("modes", modes, "shape", remedy="solve_modes(state) gives them")
    whole("count", count, 1)
    shapes = modes["shape"].transpose("mode", ...)
    values = mac(numbers("shape", shape).reshape(1, -1), shapes.values.reshape(shapes.shape[0], -1))[0]
    order = np.argsort(-values, kind="stable")[:count]
    listed = modes["mode"].values if "mode" in modes.coords else np.arange(1, values.size + 1)
    arrays = {"mode": listed[order], "mac": values[order], "cumulative": np.cumsum(values[order])}
    if "frequency" in modes:
        arrays["frequency"] = modes["frequency"].values[order]
    return xr.Dataset(described(MAC, arrays), described(MAC, {"rank": np.arange(1, order.size + 1)}))


def _rows(name: str, shapes: xr.DataArray | ArrayLike, nodal: bool) -> Array:
    """Shapes as rows of unit length."""
    if isinstance(shapes, xr.DataArray):
        single = "mode" not in shapes.dims
        array = np.asarray(shapes.values if single else shapes.transpose("mode", ...).values, dtype=np.float64)
    else:
        array = numbers(name, shapes)
        single = array.ndim == 1 or (array.ndim == 2 and nodal and array.shape[1] == 3)
    if array.ndim == 0 or array.size == 0:
        raise InputError(f"{name}: expected shapes (n, dof) or (n, node, 3), got shape {array.shape}")
    rows = array.reshape(1, -1) if single else array.reshape(array.shape[0], -1)
    length = np.linalg.norm(rows, axis=1)
    if not np.all(np.isfinite(length)) or np.any(length == 0.0):
        bad = int(np.flatnonzero(~(np.isfinite(length) & (length > 0.0)))[0])
        raise InputError(f"{name}: expected finite shapes that are not zero, got length {length[bad]} for shape {bad}")
    return np.asarray(rows / length[:, None], dtype=np.float64)
