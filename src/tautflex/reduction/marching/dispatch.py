"""One compiled stepping for several kinds of plants: internal forces are looked up by the plant's type.

Compiled code looks its kernels up while it is compiled, once for each type of plant, so that a step costs no more than
with the kernels written into it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba.extending import overload


class PlantKernels(NamedTuple):
    """Compiled internal forces of one type of plant; all three have the arguments of those of polynomials."""

    internal_force: Any
    average_force: Any
    tangent: Any


KERNELS: dict[type, PlantKernels] = {}


def _dispatched(name: str) -> Any:
    def stub(plant: Any, *arguments: Any) -> Any:
        return getattr(KERNELS[type(plant)], name)(plant, *arguments)

    @overload(stub)
    def chosen(plant: Any, *arguments: Any) -> Any:
        kernel = getattr(KERNELS[plant.instance_class], name)

        def implementation(plant: Any, *arguments: Any) -> Any:
            return kernel(plant, *arguments)

        return implementation

    return stub


internal_force, average_force, tangent = (_dispatched(name) for name in PlantKernels._fields)
