"""One compiled stepping for several kinds of reduced models: internal forces are looked up by the type of its arrays.

Compiled code looks its kernels up while it is compiled, once for each type of arrays, so that a step costs no more than
with the kernels written into it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba.extending import overload


class ForceKernels(NamedTuple):
    """Compiled internal forces of one type of arrays; all three have the arguments of those of polynomials."""

    internal_force: Any
    average_force: Any
    tangent: Any


KERNELS: dict[type, ForceKernels] = {}


def _dispatched(name: str) -> Any:
    def stub(arrays: Any, *arguments: Any) -> Any:
        return getattr(KERNELS[type(arrays)], name)(arrays, *arguments)

    @overload(stub)
    def chosen(arrays: Any, *arguments: Any) -> Any:
        kernel = getattr(KERNELS[arrays.instance_class], name)

        def implementation(arrays: Any, *arguments: Any) -> Any:
            return kernel(arrays, *arguments)

        return implementation

    return stub


internal_force, average_force, tangent = (_dispatched(name) for name in ForceKernels._fields)
