r"""Two-node Euler-Bernoulli beam with mean axial strain.

1. Kinematics: local gradients ``g = (a, s_v, s_w, theta_1, theta_2)`` with ``a = du/l``, chord slopes
   ``s_v = dv/l``, ``s_w = dw/l`` and the two nodal rotation vectors (9 numbers). Cubic Hermite interpolation
   [paper (1)-(3)] makes deflection slopes and curvatures linear in ``g``; their orthonormal Legendre coefficients
   integrate squares exactly.
2. Strain: axial ``e = mean of u' + (v'^2 + w'^2)/2`` (the element mean avoids membrane locking, theory.md 2); two
   bending strains in each plane, ``chi_0 = phi_2 - phi_1``, ``chi_1 = sqrt(3)(phi_1 + phi_2)`` with ``phi`` the end
   rotation relative to the chord, so that EI/(2 l)(chi_0^2 + chi_1^2) is the Hermite bending energy; the twist
   ``theta_2x - theta_1x``.
3. ``"green-lagrange"`` adds to bending and twist the second-order terms of the exact end rotations relative to the
   turned element, ``log(R_element^T R_node)``, expanded with the Baker-Campbell-Hausdorff formula. Bending moments
   of a prestressed frame then turn with it; without them the free antenna has spurious stiffness (the shear forces
   that balance the cables would stay behind).
"""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

import numpy as np

from tautflex.elements.axes import line_axes
from tautflex.elements.block import ElementBlock, InertiaPoints, symmetric_terms, turning_terms
from tautflex.elements.element import Element, register_element
from tautflex.numeric import Array, Indices
from tautflex.structure.groups import ElementGroup
from tautflex.structure.materials import BeamSection
from tautflex.structure.shapes import LINE2, Shape

AXIAL, SLOPE_V, SLOPE_W, X1, Y1, Z1, X2, Y2, Z2 = range(9)
ROOT3 = np.sqrt(3.0)


def _rows(*terms: tuple[int, float]) -> Array:
    row = np.zeros(9)
    for index, value in terms:
        row[index] += value
    return row


# End rotations relative to the chord; a rotation about y lowers w, hence the signs of the second plane.
RELATIVE = {
    "v": (_rows((Z1, 1.0), (SLOPE_V, -1.0)), _rows((Z2, 1.0), (SLOPE_V, -1.0))),
    "w": (_rows((Y1, -1.0), (SLOPE_W, -1.0)), _rows((Y2, -1.0), (SLOPE_W, -1.0))),
}
CHORD = {"v": _rows((SLOPE_V, 1.0)), "w": _rows((SLOPE_W, 1.0))}


def _linear() -> Array:
    bending = [
        combination
        for plane in "vw"
        for first, second in [RELATIVE[plane]]
        for combination in (second - first, ROOT3 * (first + second))
    ]
    return np.array([_rows((AXIAL, 1.0)), *bending, _rows((X2, 1.0), (X1, -1.0))])


def _axial_quadratic() -> Array:
    """Mean of (v'^2 + w'^2)/2 from the Legendre coefficients of the Hermite slopes."""
    quadratic = np.zeros((6, 9, 9))
    for plane in "vw":
        first, second = RELATIVE[plane]
        for row in (CHORD[plane], (second - first) / (2.0 * ROOT3), (first + second) / (2.0 * np.sqrt(5.0))):
            quadratic[0] += np.outer(row, row)
    return quadratic


def _second_order() -> Array:
    """Second-order terms of bending and twist (point 3 of the module's docstring)."""
    terms: list[tuple[int, int, int, float]] = []
    for end, (x, y, z) in enumerate(((X1, Y1, Z1), (X2, Y2, Z2))):
        # phi about z: + s_v a - t s_w/2 - t theta_y/2 - s_w theta_x/2, with the mean twist t = (x1 + x2)/2
        about_z = [(SLOPE_V, AXIAL, 1.0), (SLOPE_W, x, -0.5)]
        about_z += [(twist, other, -0.25) for twist in (X1, X2) for other in (SLOPE_W, y)]
        # -(phi about y): + s_w a + t s_v/2 + s_v theta_x/2 - t theta_z/2
        minus_y = [(SLOPE_W, AXIAL, 1.0), (SLOPE_V, x, 0.5)]
        minus_y += [(twist, other, sign) for twist in (X1, X2) for other, sign in ((SLOPE_V, 0.25), (z, -0.25))]
        difference = 1.0 if end else -1.0
        for strain, products in ((1, about_z), (3, minus_y)):
            terms += [(strain, i, j, difference * c) for i, j, c in products]
            terms += [(strain + 1, i, j, ROOT3 * c) for i, j, c in products]
    for slope, first, second in ((SLOPE_W, Z1, Z2), (SLOPE_V, Y1, Y2)):
        terms += [(5, slope, second, 0.5), (5, slope, first, -0.5)]
    return symmetric_terms(6, 9, terms)


LINEAR = _linear()
QUADRATIC = {"von-karman": _axial_quadratic(), "green-lagrange": _axial_quadratic() + _second_order()}


def _local_quadratic() -> Array:
    """In the local frame, where the chord is exact: shortening by bending, and half the square of the twist."""
    quadratic = np.zeros((7, 9, 9))
    quadratic[:6] = _axial_quadratic()
    for plane in "vw":
        quadratic[0] -= np.outer(CHORD[plane], CHORD[plane])
    quadratic[6] = np.outer(LINEAR[5], LINEAR[5])
    return quadratic


LOCAL_LINEAR, LOCAL_QUADRATIC = np.vstack([LINEAR, np.zeros(9)]), _local_quadratic()


@register_element
class Beam(Element):
    """Member of a frame; see the top of this file."""

    kind: ClassVar[str] = "beam"
    shape: ClassVar[Shape] = LINE2

    @staticmethod
    def declare(nodes: Array, group: ElementGroup, dofs: Indices) -> ElementBlock:
        """Beam elements as data; stresses are resultants [N] (bending and twist divided by the length), measure [m]."""
        section = group.section
        assert isinstance(section, BeamSection)
        ends = nodes[group.connectivity]
        axes, length = line_axes(ends, group.orientation)
        count = len(dofs)
        gradient = np.zeros((count, 9, 12))
        slope = axes / length[:, None, None]
        gradient[:, 0:3, 0:3], gradient[:, 0:3, 6:9] = -slope, slope
        gradient[:, 3:6, 3:6] = gradient[:, 6:9, 9:12] = axes
        material = section.material
        stiffness = np.array(
            [0.0]
            + [material.youngs_modulus * section.inertia_z] * 2
            + [material.youngs_modulus * section.inertia_y] * 2
            + [material.shear_modulus * section.torsion_constant]
        )
        elasticity = np.einsum("s,n->ns", stiffness, length**-2)
        elasticity[:, 0] = material.youngs_modulus * section.area
        matrix = np.einsum("ns,st->nst", elasticity, np.eye(6))
        initial = group.initial[:, :1] * np.eye(1, 6)
        turns = section.strain == "corotational"
        if turns:
            # Wagner's term: twisted fibres at the distance r are longer by r^2 theta'^2/2, on average by I_p/A of it.
            longer = (section.inertia_y + section.inertia_z) / section.area / length**2
            fibre = np.zeros((count, 7))
            fibre[:, 0], fibre[:, 6] = 1.0, longer
            matrix = np.pad(matrix, ((0, 0), (0, 1), (0, 1)))
            matrix[:, 0, 0] = 0.0
            matrix += material.youngs_modulus * section.area * fibre[:, :, None] * fibre[:, None, :]
            initial = group.initial[:, :1] * fibre
        return ElementBlock(
            kind="beam",
            dofs=dofs,
            gradient=gradient,
            linear=LOCAL_LINEAR if turns else LINEAR,
            quadratic=LOCAL_QUADRATIC if turns else QUADRATIC[section.strain],
            elasticity=matrix,
            initial_stress=initial,
            measure=length,
            size=np.ones(count),
            inertia=_inertia(section, ends, axes, length),
            axes=axes,
            material=material,
            turns=turns,
        )


def _inertia(section: BeamSection, ends: Array, axes: Array, length: Array) -> InertiaPoints:
    """Four Gauss points along the axis (Hermite products have degree 6) by four in the cross-section.

    The four section points reproduce area and both second moments; they move with the axis and turn with the twist,
    which gives the polar inertia rho (I_y + I_z), and with rotary inertia also with the slope, ``-y v' - z w'``.

    Where ends turn by any angle, interpolations may not know the line's direction: axis and rotation are linear, and
    the difference of both rotations lifts the axis by ``l e (1 - e)/2``, the deflection of constant curvature. A rigid
    rotation about an axis that stays has its exact kinetic energy then, however far it goes.
    """
    turns = section.strain == "corotational"
    abscissa, weight = np.polynomial.legendre.leggauss(4)
    ratio, weight = 0.5 * (abscissa + 1.0), 0.5 * weight
    # What has no stiffness lies on the axis: it does not turn.
    share = section.material.density * section.area / section.mass_per_measure
    radius_y = np.sqrt(section.inertia_z / section.area * share)
    radius_z = np.sqrt(section.inertia_y / section.area * share)
    local = np.zeros((len(length), 4, 2, 2, 3, 12))
    position = np.zeros((len(length), 4, 2, 2, 3))
    for p, e in enumerate(ratio):
        shape = (1 - 3 * e**2 + 2 * e**3, 3 * e**2 - 2 * e**3)
        turn = (length * (e - 2 * e**2 + e**3), length * (e**3 - e**2))
        slope = ((6 * e**2 - 6 * e) / length, (6 * e - 6 * e**2) / length)
        bend = (1 - 4 * e + 3 * e**2, 3 * e**2 - 2 * e)
        if turns:
            shape, slope, bend = (1 - e, e), (np.zeros(1), np.zeros(1)), (1 - e, e)
            turn = (0.5 * length * e * (1 - e), -0.5 * length * e * (1 - e))
        for i, side_y in enumerate((-radius_y, radius_y)):
            for j, side_z in enumerate((-radius_z, radius_z)):
                point = local[:, p, i, j]
                for end, lever in enumerate((1.0 - e, e)):
                    column = 6 * end
                    point[:, 0, column] = lever
                    point[:, 1, column + 1] = point[:, 2, column + 2] = shape[end]
                    point[:, 1, column + 5], point[:, 2, column + 4] = turn[end], -turn[end]
                    point[:, 1, column + 3], point[:, 2, column + 3] = -side_z * lever, side_y * lever
                    if turns or section.rotary_inertia:
                        point[:, 0, column + 1], point[:, 0, column + 5] = -side_y * slope[end], -side_y * bend[end]
                        point[:, 0, column + 2], point[:, 0, column + 4] = -side_z * slope[end], side_z * bend[end]
                position[:, p, i, j] = (1 - e) * ends[:, 0] + e * ends[:, 1]
                position[:, p, i, j] += side_y * axes[:, 1] + side_z * axes[:, 2]
    # Local displacements from local unknowns -> global displacements from global unknowns.
    blocks = local.reshape(len(length), 16, 3, 4, 3)
    turned = np.einsum("nal,npabc,ncg->nplbg", axes, blocks, axes)
    density = section.mass_per_measure * length
    mass = density[:, None] * np.repeat(weight / 4.0, 4)[None, :]
    points = InertiaPoints(mass, turned.reshape(len(length), 16, 3, 12), position.reshape(len(length), 16, 3))
    if not turns:
        return points
    rotation = np.zeros((1, 4, 3, 12))
    rotation[0, :, :, 3:6] = (1.0 - ratio)[:, None, None] * np.eye(3)
    rotation[0, :, :, 9:12] = ratio[:, None, None] * np.eye(3)
    spread = np.einsum("k,nka,nkb->nab", [radius_y**2, radius_z**2], axes[:, 1:], axes[:, 1:])
    second = np.einsum("n,p,nab->npab", density, weight, spread)
    return replace(points, turning=turning_terms(second, rotation))
