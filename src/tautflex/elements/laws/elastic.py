"""Elastic law: the trial stress is the stress, compression is carried."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from tautflex.elements.laws.law import Law, register_law
from tautflex.structure.materials import Material


@register_law
@dataclass(frozen=True)
class Elastic(Law):
    """Linear stress; the kernel works it off without a function."""

    name: ClassVar[str] = "elastic"
    sections: ClassVar[tuple[str, ...]] = ("membrane", "cable", "beam")

    def parameters(self, material: Material) -> tuple[float, ...]:
        """None: elastic matrices are data of the elements."""
        return ()
