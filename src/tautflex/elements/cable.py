r"""Two-node pretensioned cable.

1. Kinematics: gradients ``g = (s', v', w')``, the axial and the two lateral slopes [paper (4)-(5)].
2. Strain: ``e = s' + (v'^2 + w'^2)/2`` [paper (16), with (19) read as v and w]; Green-Lagrange adds ``s'^2/2``.
3. Stress: ``T0/A + E e`` [paper (20)-(21)].
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from tautflex.elements.axes import line_axes
from tautflex.elements.block import ElementBlock, symmetric_terms, translating_points
from tautflex.elements.element import Element, register_element
from tautflex.elements.laws import law_of
from tautflex.numeric import Array, Indices
from tautflex.structure.groups import ElementGroup
from tautflex.structure.materials import CableSection
from tautflex.structure.shapes import LINE2, Shape

LINEAR = np.array([[1.0, 0.0, 0.0]])
QUADRATIC = {
    "von-karman": symmetric_terms(1, 3, [(0, 1, 1, 0.5), (0, 2, 2, 0.5)]),
    "green-lagrange": symmetric_terms(1, 3, [(0, 0, 0, 0.5), (0, 1, 1, 0.5), (0, 2, 2, 0.5)]),
}


@register_element
class Cable(Element):
    """Pretensioned string; see the top of this file."""

    kind: ClassVar[str] = "cable"
    shape: ClassVar[Shape] = LINE2

    @staticmethod
    def declare(nodes: Array, group: ElementGroup, dofs: Indices) -> ElementBlock:
        """Cable elements as data; stresses in Pa, measure = volume [m^3]."""
        section = group.section
        assert isinstance(section, CableSection)
        ends = nodes[group.connectivity]
        axes, length = line_axes(ends, group.orientation)
        slope = axes / length[:, None, None]
        volume = section.area * length
        # Two-point Gauss rule: exact for products of two linear functions.
        ratio = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)
        functions = np.stack([1.0 - ratio, ratio], axis=1)
        mass = section.material.density * volume + section.nonstructural_mass * length
        return ElementBlock(
            kind="cable",
            dofs=dofs,
            gradient=np.concatenate([-slope, slope], axis=2),
            linear=LINEAR,
            quadratic=QUADRATIC[section.strain],
            elasticity=np.full((len(dofs), 1, 1), section.material.youngs_modulus),
            initial_stress=group.initial / section.area,
            measure=volume,
            size=np.full(len(dofs), section.area),
            inertia=translating_points(np.repeat(0.5 * mass[:, None], 2, axis=1), functions, ends),
            axes=axes,
            material=section.material,
            law=law_of(section),
        )
