"""An element: eight-node membrane, the serendipity quadrilateral with a node in the middle of each side."""

from __future__ import annotations

from typing import ClassVar

import tautflex as tf

QUAD8 = tf.Shape(
    "quad8",
    "quad",
    nodes=((-1, -1), (1, -1), (1, 1), (-1, 1), (0, -1), (1, 0), (0, 1), (-1, 0)),
    exponents=((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (2, 1), (1, 2)),
    corners=4,
    edges=((0, 4, 1), (1, 5, 2), (2, 6, 3), (3, 7, 0)),
    split=((0, 4, 7), (1, 5, 4), (2, 6, 5), (3, 7, 6), (4, 5, 6), (4, 6, 7)),
    strain_degree=5,
    product_degree=5,
    vtk_cell=23,
)


@tf.register
class Quad8(tf.Element):
    """Quadratic membrane of four sides."""

    kind: ClassVar[str] = "membrane"
    shape: ClassVar[tf.Shape] = QUAD8

    @staticmethod
    def declare(nodes, group, dofs):
        return tf.isoparametric_membrane(nodes, group, dofs)
