r"""Antenna whose film is cut along arcs that cords in its edges keep taut, everywhere under one chosen stress.

A film under the uniform resultants ``N_x, N_y`` [N/m] pulls on an edge by ``N n`` per length, n normal to it in the
plane. For a cord between two points ``L`` apart along x, from its lowest point on (y from there, outwards):
``H' = -N_x y'`` and ``(H y')' = N_y`` with the pull along x ``H``, so that ``H = H_0 - N_x y`` and

    N_x y^2 - 2 H_0 y + N_y x^2 = 0,

an ellipse, for equal resultants a circle of radius ``H_0 / N``. With the sag d, ``H_0 = N_y L^2/(8 d) + N_x d/2``; an
end is pulled by ``H_0 - N_x d`` along and ``N_y L/2`` across the edge. What holds it there carries both.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.numeric import Array, Indices
from tautflex.structure.antenna import AntennaLayout, film_mesh, frame_points, framed, straight_cables
from tautflex.structure.groups import ElementGroup
from tautflex.structure.materials import BeamSection, CableSection, MembraneSection
from tautflex.structure.model import Model
from tautflex.structure.shapes import LINE2

CORNERS = ("straight", "diagonal")
# Largest sum of the slopes' angles where two arcs meet at a corner [rad].
_WIDEST = 0.45 * np.pi


@dataclass(frozen=True)
class Arc:
    """Cord between two points of an edge.

    Parameters
    ----------
    span
        Distance of the points [m].
    sag
        Depth of the cut [m], > 0; at its ends the ellipse must still go along the edge.
    along, across
        Film resultants along and across the edge [N/m], > 0.
    """

    span: float
    sag: float
    along: float
    across: float

    def __post_init__(self) -> None:
        limit = 0.5 * self.span * np.sqrt(self.across / self.along)
        if not 0.0 < self.sag < limit:
            raise InputError(
                f"sag: expected a cut between 0 and {limit:.4g} m over {self.span:.4g} m, where the arc under "
                f"{self.along:.4g} N/m along and {self.across:.4g} N/m across the edge turns back, got "
                f"{self.sag:.4g} m; cut less"
            )

    @property
    def lowest_pull(self) -> float:
        """Pull along the edge in its middle [N]."""
        return self.across * self.span**2 / (8.0 * self.sag) + 0.5 * self.along * self.sag

    @property
    def end_pull(self) -> float:
        """Pull along the edge at its ends [N]."""
        return self.lowest_pull - self.along * self.sag

    @property
    def end_slope(self) -> float:
        """Slope at its ends."""
        return 0.5 * self.across * self.span / self.end_pull

    def depth(self, place: Array) -> Array:
        """Depth of the cut [m] at places along the edge from the middle of the span [m]."""
        push, square = self.lowest_pull, self.across * place**2
        return np.asarray(self.sag - square / (push + np.sqrt(push**2 - self.along * square)))

    def pull(self, place: Array) -> Array:
        """Pull along the edge [N] at places along it from the middle of the span [m]."""
        return self.lowest_pull - self.along * (self.sag - self.depth(place))


def build_scalloped_antenna(
    layout: AntennaLayout,
    membrane: MembraneSection,
    cable: CableSection,
    cord: CableSection,
    frame: BeamSection,
    *,
    membrane_stress: tuple[float, float],
    sag: float = 0.1,
    corners: str = "straight",
) -> Model:
    """Film with scalloped edges and cords in them, held in a frame by cables between the arcs.

    All tensions follow from the film's stress and the cut; the nodes of a mesh stand on the arcs, so that its balance
    is that of the arcs to second order in the mesh (`tautflex.find_form` makes it exact).

    Parameters
    ----------
    layout
        Geometry with a frame; length and width from corner to corner. Cables stand at the ends of the arcs; its
        distribution is not used.
    membrane, cable, cord, frame
        Sections.
    membrane_stress
        Of the whole film along x and y [Pa], > 0.
    sag
        Depth of the cuts over their span, > 0.
    corners
        ``"straight"``: two cables at each corner, along x and y; ``"diagonal"``: one strap to the frame's corner, whose
        direction then decides how deep the short edges are cut.

    Returns
    -------
    Model
        Cords are the last group of its elements.

    Raises
    ------
    InputError
        If a value is out of range, or the cuts leave no film at the corners.
    """
    for name, stress in zip("xy", checks.float_array("membrane_stress", membrane_stress, (2,)), strict=True):
        checks.positive(f"membrane_stress along {name}", stress)
    checks.positive("sag", sag)
    checks.one_of("corners", corners, CORNERS)
    ring = frame_points(layout, layout.stations)
    arcs = _arcs(layout, membrane.thickness * np.array(membrane_stress), sag, corners == "diagonal")
    nodes, elements = film_mesh(layout, layout.stations)
    nodes, cords, cord_tension = _cut(layout, nodes, arcs)
    model = framed(
        layout,
        (nodes, elements),
        ring,
        _cables(layout, arcs, corners == "diagonal"),
        sections=(membrane, cable, frame),
        membrane_stress=(membrane_stress[0], membrane_stress[1], 0.0),
        prestress_mode="equilibrium",
    )
    group = ElementGroup(cord, LINE2, cords, cord_tension[:, None], np.array([0.0, 0.0, 1.0]))
    return replace(model, groups=(*model.groups, group))


Arcs = tuple[Arc, Arc]
"""One of a long edge and one of a short edge; all of an edge are alike."""


def _arcs(layout: AntennaLayout, resultants: Array, sag: float, diagonal: bool) -> Arcs:
    """Arcs under resultants along x and y [N/m]; InputError if they leave no film."""
    n_x, n_y = map(float, resultants)
    spans = [float(own[1] - own[0]) for own in layout.stations]
    long, depth = Arc(spans[0], sag * spans[0], n_x, n_y), sag * spans[1]
    if diagonal:
        length, width = layout.frame_sides
        slope = (width - layout.width) / (length - layout.length)
        wanted = slope * (long.end_pull + 0.5 * n_x * spans[1]) - 0.5 * n_y * spans[0]
        # Of N_x L^2 / (8 d) - N_y d / 2 = H: the pull along the short edge that turns the strap to the corner.
        depth = float(np.hypot(wanted, 0.5 * np.sqrt(n_x * n_y) * spans[1]) - wanted) / n_y
    short = Arc(spans[1], depth, n_y, n_x)
    told = f"got {long.sag:.4g} m on the long and {short.sag:.4g} m on the short edges; cut less, or lay more arcs"
    if long.sag >= 0.45 * layout.width or short.sag >= 0.45 * layout.length:
        raise InputError(f"sag: expected cuts that do not meet in the middle of the film, {told}")
    if np.arctan(long.end_slope) + np.arctan(short.end_slope) > _WIDEST:
        raise InputError(f"sag: expected cuts that leave a corner of 9 degrees at least between them, {told}")
    return long, short


def _cables(layout: AntennaLayout, arcs: Arcs, diagonal: bool) -> tuple[Array, Array]:
    """Ends [m] and tensions [N] of the cables that hold the ends of the arcs."""
    stations, tensions = layout.stations, []
    for own, other, places in zip(arcs, arcs[::-1], stations, strict=True):
        tension = np.full(len(places), own.across * own.span)
        tension[[0, -1]] = 0.5 * own.across * own.span + other.end_pull
        tensions.append(tension)
    if not diagonal:
        return straight_cables(layout, stations, (tensions[0], tensions[1]))
    ends, tension = straight_cables(
        layout, (stations[0][1:-1], stations[1][1:-1]), (tensions[0][1:-1], tensions[1][1:-1])
    )
    corners = np.array([(x, y) for x in (-0.5, 0.5) for y in (-0.5, 0.5)])
    sides = [(layout.length, layout.width), layout.frame_sides]
    straps = np.stack([corners * np.array(side) for side in sides], axis=1)
    pull = float(np.hypot(tensions[0][0], tensions[1][0]))
    return np.concatenate([ends.reshape(-1, 2, 2), straps]), np.append(tension, np.full(4, pull))


def _cut(layout: AntennaLayout, nodes: Array, arcs: Arcs) -> tuple[Array, Indices, Array]:
    """Film nodes of the rectangle drawn in to the arcs, the cords in its edges, and their tensions [N]."""
    sides, cut, cords, tension = np.array([layout.length, layout.width]), nodes.copy(), [], []
    for axis, arc in enumerate(arcs):
        first = layout.stations[axis][0]

        def place(along: Array, first: float = first, arc: Arc = arc) -> Array:
            return np.asarray(np.mod(along - first, arc.span) - 0.5 * arc.span)

        other = 1 - axis
        cut[:, other] *= 1.0 - 2.0 * arc.depth(place(nodes[:, axis])) / sides[other]
        for part in (-0.5, 0.5):
            edge = np.flatnonzero(np.abs(nodes[:, other] - part * sides[other]) < 1e-9 * sides[other])
            edge = edge[np.argsort(nodes[edge, axis])]
            along = nodes[edge, axis]
            cords.append(np.column_stack([edge[:-1], edge[1:]]))
            tension.append(arc.pull(place(0.5 * (along[:-1] + along[1:]))) / np.diff(along))
    lines = np.concatenate(cords)
    length = np.linalg.norm(cut[lines[:, 1]] - cut[lines[:, 0]], axis=1)
    return cut, lines, np.concatenate(tension) * length
