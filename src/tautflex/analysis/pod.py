"""Proper orthogonal decomposition of a response, and its dominant shape [paper, eqs. (50)-(53)]."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike
from scipy import linalg, sparse
from scipy.sparse.linalg import splu

from tautflex.checks import between, float_array, numbers, whole
from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.solvers.variables import MESH, POD, about, dataset_of, described

Mass: TypeAlias = "Array | sparse.sparray | sparse.spmatrix"


def pod(
    data: xr.Dataset | xr.DataArray | ArrayLike,
    modes: int | None = None,
    mass: Mass | None = None,
    energy: float = 0.99,
) -> xr.Dataset:
    r"""Decompose a response into proper orthogonal modes.

    The modes p and values lambda solve R p = lambda p with R = X^T X / n [paper, eqs. (50), (51)], X
    holding one snapshot per row. They come from the singular values of X: R is never formed, so small
    values keep their digits. With a mass matrix W the inner product is p^T W q, i.e. R = X^T X W / n, and
    the modes satisfy p^T W p = 1.

    Parameters
    ----------
    data
        Dataset of a run with ``displacement(field_time, node, component)`` [m], that DataArray, any
        DataArray whose first dimension is time, or an array (snapshot, dof) or (snapshot, node, 3). The
        mean is kept, as in the paper; subtract it first if the motion about it is wanted.
    modes
        Number of modes to keep; by default as many as ``energy`` needs.
    mass
        Symmetric positive definite inner product (dof, dof), dense or sparse, dof in the order of ``data``.
    energy
        Cumulative participation to be reached if ``modes`` is None, in (0, 1].

    Returns
    -------
    xarray.Dataset
        ``shape(mode, ...)`` with the data's own dimensions after time, normalised to p^T W p = 1, largest
        entry positive; ``value(mode)`` lambda [unit^2, with mass kg unit^2]; ``participation(mode)`` chi
        [paper, eq. (52)] and ``cumulative(mode)`` nu [paper, eq. (53)], both relative to all modes, kept or
        not; ``coefficient(time, mode)``, the response along each mode; the mesh where ``data`` carries one.

    Raises
    ------
    InputError
        If the data are empty, zero or not finite, ``mass`` does not fit or is not positive definite, or
        ``modes`` or ``energy`` is out of range.

    Examples
    --------
    >>> import tautflex as tf
    >>> run = tf.load_run("m2/run.nc")
    >>> tf.pod(run.data, modes=2).sizes["mode"]
    2
    """
    field, extra = _field(data)
    snapshots = float_array(str(field.name or "data"), field.values.reshape(field.shape[0], -1), (None, None))
    if snapshots.size == 0 or not np.any(snapshots):
        raise InputError("data: expected a response that is not zero, got only zeros; store fields during the motion")
    between("energy", energy, 0.0, 1.0, remedy="0.99 keeps 99 % of the energy")
    weighted = snapshots if mass is None else _weighted(snapshots, mass)
    left, singular, right = linalg.svd(weighted, full_matrices=False)
    values = singular**2 / snapshots.shape[0]
    participation = values / values.sum()
    cumulative = np.cumsum(participation)
    rank = int(np.count_nonzero(singular > singular[0] * max(snapshots.shape) * np.finfo(float).eps))
    count = _mode_count(modes, energy, cumulative, rank)
    shapes = right[:count] if mass is None else (left[:, :count].T @ snapshots) / singular[:count, None]
    signs = np.sign(shapes[np.arange(count), np.abs(shapes).argmax(axis=1)])
    shapes = shapes * signs[:, None]
    coefficients = left[:, :count] * (singular[:count] * signs)
    numbers = {"value": values, "participation": participation, "cumulative": cumulative}
    return (
        _to_dataset(field, shapes, coefficients, {name: each[:count] for name, each in numbers.items()})
        .assign(extra)
        .assign_attrs(energy=float(energy), snapshots=snapshots.shape[0], weighted=mass is not None)
    )


def dominant_shape(pod_data: xr.Dataset, energy: float = 0.99) -> xr.DataArray:
    """Combine the modes that together reach ``energy`` into one shape, the paper's dominant shape.

    The paper names "the combined shape of POMs with a participation factor of 99 %" without a formula. Here
    each mode enters with its participation factor chi [paper, eq. (52)] and with the sign of its
    coefficient at the instant of the largest response, so that the result does not depend on the arbitrary
    signs of the modes.

    Parameters
    ----------
    pod_data
        Result of :func:`pod`.
    energy
        Cumulative participation to be reached, in (0, 1].

    Returns
    -------
    xarray.DataArray
        Shape with the dimensions of the modes, scaled to a largest absolute entry of +1; attribute
        ``modes`` holds how many modes were combined and ``cumulative`` their participation.

    Raises
    ------
    InputError
        If ``pod_data`` is not a result of :func:`pod` or holds too few modes for ``energy``.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> run = tf.simulate(state, tf.Stop(0.628, 0.2), time_step=0.01, end_time=0.5, fields="all")
    >>> shape = tf.dominant_shape(tf.pod(run.data), energy=0.9)
    >>> print(f"{float(abs(shape).max()):.1f}, {shape.sizes['node']} nodes")
    1.0, 104 nodes
    """
    parts = ("shape", "participation", "cumulative", "coefficient")
    pod_data = dataset_of("pod_data", pod_data, *parts, remedy="pod(run) gives it")
    between("energy", energy, 0.0, 1.0)
    cumulative = pod_data["cumulative"].values
    if cumulative[-1] < energy - 1e-9:
        raise InputError(
            f"energy: expected at most the {cumulative[-1]:.4f} that the {cumulative.size} kept modes reach, "
            f"got {energy:g}; call pod with energy={energy:g}"
        )
    count = min(int(np.searchsorted(cumulative, energy - 1e-12)) + 1, cumulative.size)
    coefficient = pod_data["coefficient"].values
    largest = int(np.sum(coefficient**2, axis=1).argmax())
    weight = pod_data["participation"].values[:count] * np.sign(coefficient[largest, :count])
    shapes = pod_data["shape"]
    combined = np.tensordot(weight, shapes.values[:count], axes=1)
    combined = combined / combined.flat[np.abs(combined).argmax()]
    result = shapes.isel(mode=0, drop=True).copy(data=combined)
    result.attrs = {**about(POD["dominant_shape"]), "modes": count, "cumulative": float(cumulative[count - 1])}
    return result.rename("dominant_shape")


def _field(data: xr.Dataset | xr.DataArray | ArrayLike) -> tuple[xr.DataArray, dict[str, xr.DataArray]]:
    """Snapshots with time first, and the mesh to carry along."""
    if isinstance(data, xr.DataArray):
        field = data
    elif isinstance(data, xr.Dataset) or (hasattr(data, "data") and not isinstance(data, np.ndarray)):
        run = dataset_of("data", data, "displacement", remedy="simulate with fields='all' or a list of times")
        return run["displacement"], {name: run[name] for name in MESH if name in run}
    else:
        array = numbers("data", data)
        dims = {2: ("snapshot", "dof"), 3: ("snapshot", "node", "component")}.get(array.ndim)
        if dims is None:
            raise InputError(f"data: expected shape (snapshot, dof) or (snapshot, node, 3), got {array.shape}")
        field = xr.DataArray(array, dims=dims)
    if field.ndim < 2:
        raise InputError(f"data: expected a time dimension and at least one more, got {field.dims}")
    return field, {}


def _weighted(snapshots: Array, mass: Mass) -> Array:
    """Return X C with W = C C^T, so that its singular vectors are orthogonal in the W inner product."""
    size = snapshots.shape[1]
    if getattr(mass, "shape", None) != (size, size):
        raise InputError(
            f"mass: expected shape ({size}, {size}), one row per entry of a snapshot, got "
            f"{getattr(mass, 'shape', type(mass).__name__)}; take the rows and columns of the translations"
        )
    matrix: Any = sparse.csc_array(mass)
    bad = InputError("mass: expected a symmetric positive definite matrix, got one that is not; check it")
    if abs(matrix - matrix.T).max() > 1e-12 * abs(matrix).max():
        raise bad
    try:  # a symmetric ordering without pivoting turns LU into L D L^T of the permuted matrix
        symmetric = {"SymmetricMode": True}
        factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=symmetric)
    except RuntimeError:
        raise bad from None
    diagonal = factors.U.diagonal()
    if np.any(factors.perm_r != factors.perm_c) or np.any(diagonal <= 0.0):
        raise bad
    factor: Any = factors.L @ sparse.diags_array(np.sqrt(diagonal))
    ordered = snapshots[:, np.argsort(factors.perm_r)]
    return np.asarray((factor.T @ ordered.T).T, dtype=np.float64)


def _mode_count(modes: int | None, energy: float, cumulative: Array, rank: int) -> int:
    if modes is None:
        return min(int(np.searchsorted(cumulative, energy - 1e-12)) + 1, rank)
    return min(whole("modes", modes, 1, remedy="None keeps what energy needs"), rank)


def _to_dataset(field: xr.DataArray, shapes: Array, coefficients: Array, numbers: dict[str, Array]) -> xr.Dataset:
    time, *rest = field.dims
    count, units = len(shapes), str(field.attrs.get("units", "1"))
    coords: dict[Any, Any] = described(POD, {"mode": np.arange(1, count + 1)})
    coords |= {name: field.coords[name] for name in field.dims if name in field.coords}
    data: dict[Any, Any] = described(POD, numbers, units=units)
    data["shape"] = (("mode", *rest), shapes.reshape(count, *field.shape[1:]), about(POD["shape"]))
    data["coefficient"] = ((time, "mode"), coefficients, about(POD["coefficient"], units=units))
    return xr.Dataset(data, coords)
