"""Array types, compiler switches and cross products of all numerical rooms."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import cache
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tautflex.compiling import temporary_place, watch
from tautflex.errors import InputError

Array: TypeAlias = NDArray[np.float64]
Complex: TypeAlias = NDArray[np.complex128]
Indices: TypeAlias = NDArray[np.int64]
Places: TypeAlias = NDArray[np.uint32]
"""Positions in vectors and patterns as kernels read them: half the memory of `Indices`."""
Mask: TypeAlias = NDArray[np.bool_]

_OWN = "tautflex", "numpy", "scipy", "numba"


@contextmanager
def within_arithmetic() -> Iterator[None]:
    """Make one InputError, also as a decorator, of numbers that overflow, of warnings about them, of singular matrices.

    A number that overflowed inside a norm or a comparison may not show in the result.
    """
    try:
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            yield
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        place = error.__traceback__
        while place is not None and place.tb_next is not None:
            place = place.tb_next
        if place is not None and str(place.tb_frame.f_globals.get("__name__")).partition(".")[0] not in _OWN:
            raise  # the mistake of a function or class of the user's own
        text = f"numbers: expected ones that arithmetic can hold, got none ({error})"
        raise InputError(
            f"{text}; compare sizes, stiffnesses, densities, tensions and rates, and their units"
        ) from None


@cache
def _threads() -> Any:
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def one_thread() -> AbstractContextManager[object]:
    """Keep BLAS from more threads inside: vectors of a step are too short for them, they wait for each other."""
    limited: AbstractContextManager[object] = _threads().limit(limits=1, user_api="blas")
    return limited


_LINKED = "0.68."  # versions of Numba whose inside `tautflex.linking` knows; others compile as they do by themselves


def jit(function: Callable[..., Any]) -> Any:
    """Compile a kernel; the machine code is kept on disk.

    Sums keep their order and products are not fused: compilers inline as they like, and linkers take the first loaded
    of several copies, so that anything else has other last bits from one process to the next. Long sums are written
    out in several parts where their speed counts.
    """
    # Here, because it takes longer to import than all that needs nothing but the types above.
    import numba

    if numba.__version__.startswith(_LINKED):
        from tautflex.linking import Kernel
    else:
        from numba.core.registry import CPUDispatcher as Kernel  # type: ignore[assignment]

    watch()
    kernel = Kernel(function, targetoptions={"nopython": True, "boundscheck": None, "error_model": "numpy"})
    try:
        kernel.enable_caching()
    except RuntimeError:  # no place to keep code in
        numba.config.CACHE_DIR = temporary_place()  # type: ignore[attr-defined]
        if temporary_place():
            kernel.enable_caching()
    return kernel


def cross(a: Array, b: Array) -> Array:
    """Cross product of two vectors, shape (3,); numpy's general one takes thirty times as long."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def cross_matrix(vector: ArrayLike) -> Array:
    """Matrix S(v) with S(v) a = v x a, shape (3, 3)."""
    x, y, z = np.asarray(vector, dtype=float).tolist()
    return np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))


def cross_matrices(vectors: Array) -> Array:
    """Matrices S(v) of many vectors, shape (n, 3) -> (n, 3, 3)."""
    x, y, z = vectors.T
    none = np.zeros_like(x)
    return np.stack([none, -z, y, z, none, -x, -y, x, none], axis=1).reshape(-1, 3, 3)
