"""Parametric builder of the paper's antenna: rectangular film, perpendicular cables, rectangular frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.numeric import Array, Indices, Mask
from tautflex.structure.groups import Support
from tautflex.structure.materials import BeamSection, CableSection, MembraneSection
from tautflex.structure.mesh import graded_lines, rectangle_mesh
from tautflex.structure.model import Model
from tautflex.structure.shapes import surface_shape

FRAME_SUPPORTS = ("corners", "all", "axis", "short-side", "free")
DISTRIBUTIONS = ("equal", "tributary")
Stations = tuple[Array, Array]
"""Where cables stand along the long edges (x) and along the short ones (y) [m], increasing, corners included."""


@dataclass(frozen=True)
class AntennaLayout:
    """Geometry of an antenna in the plane z = 0, centred at the origin, x along the long side.

    Parameters
    ----------
    length, width
        Film [m].
    divisions
        Cells of the film along x and y.
    pattern
        ``"alternating"`` or ``"regular"`` diagonals.
    frame_length, frame_width
        Frame centre lines [m]; both None gives a film whose four edges are fixed.
    cables_per_long_edge, cables_per_short_edge
        Cables on each edge, evenly spaced, the first and last at the film's corners.
    distribution
        ``"equal"``: every cable carries the pretension; ``"tributary"``: corner cables carry half, which puts
        a film of linear elements with a cable at every edge node in exact equilibrium.
    support
        Clamped frame nodes: its ``"corners"``, ``"all"``, the two points on the x ``"axis"``, both
        ``"short-side"``s, or none (``"free"``).
    element
        Shape of the film's elements, ``"triangle3"``, ``"triangle6"``, ``"quad4"`` or a registered one. Cables stand
        where the layout puts them: with nodes in the middle of the sides, these carry cables too.
    cable_segments
        Elements of each cable, which can swing between film and frame if there are several.
    """

    length: float
    width: float
    divisions: tuple[int, int]
    pattern: str = "alternating"
    frame_length: float | None = None
    frame_width: float | None = None
    cables_per_long_edge: int = 2
    cables_per_short_edge: int = 2
    distribution: str = "equal"
    support: str = "corners"
    element: str = "triangle3"
    cable_segments: int = 1

    def __post_init__(self) -> None:
        checks.positive("length", self.length)
        checks.positive("width", self.width)
        checks.one_of("support", self.support, FRAME_SUPPORTS)
        checks.one_of("distribution", self.distribution, DISTRIBUTIONS)
        surface_shape("element", self.element)
        checks.whole("cable_segments", self.cable_segments, 1)
        if (self.frame_length is None) != (self.frame_width is None):
            raise InputError("frame_length, frame_width: expected both or neither; give the missing one")
        if min(self.divisions) < 1:
            raise InputError(f"divisions: expected two integers >= 1, got {self.divisions}")

    @property
    def frame_sides(self) -> tuple[float, float]:
        """Frame centre lines along x and y [m]; InputError if there is no frame around the film."""
        if self.frame_length is None or self.frame_width is None:
            raise InputError("layout: expected frame_length and frame_width, got None; use build_fixed_film instead")
        if self.frame_length <= self.length or self.frame_width <= self.width:
            raise InputError("layout: expected a frame larger than the film on both sides; enlarge the frame")
        return self.frame_length, self.frame_width

    @property
    def stations(self) -> Stations:
        """Where cables stand."""
        return (
            np.linspace(-0.5, 0.5, self.cables_per_long_edge) * self.length,
            np.linspace(-0.5, 0.5, self.cables_per_short_edge) * self.width,
        )


def build_fixed_film(layout: AntennaLayout, membrane: MembraneSection, stress: tuple[float, float, float]) -> Model:
    """Rectangular film with all four edges fixed under a given uniform stress (sx, sy, txy) [Pa]."""
    ends = 0.5 * np.array([layout.length, layout.width])
    stations = np.outer(ends, [-1.0, 1.0])
    nodes, elements = film_mesh(layout, (stations[0], stations[1]))
    edge = np.any(np.abs(nodes[:, :2]) > ends * (1 - 1e-12), axis=1)
    return Model.from_mesh(
        nodes,
        surfaces={layout.element: elements},
        membrane=membrane,
        membrane_stress=stress,
        supports=(Support.pinned(np.flatnonzero(edge)),),
    )


def build_antenna(
    layout: AntennaLayout,
    membrane: MembraneSection,
    cable: CableSection,
    frame: BeamSection,
    *,
    pretension_x: float,
    pretension_y: float,
    membrane_stress: tuple[float, float, float] = (0.0, 0.0, 0.0),
    prestress_mode: str = "equilibrium",
) -> Model:
    """Film, cables and frame of the paper's Fig. 1b.

    Parameters
    ----------
    layout
        Geometry.
    membrane, cable, frame
        Sections; frame ``inertia_z`` acts in the antenna's plane, ``inertia_y`` out of it.
    pretension_x, pretension_y
        Tension per cable on the short edges (pulling along x) and on the long edges (along y) [N].
    membrane_stress
        Given film stress [Pa], used by ``prestress_mode="uniform"``.
    prestress_mode
        See `Model.from_mesh`.

    Returns
    -------
    Model

    Raises
    ------
    InputError
        If the layout has no frame around the film, or fewer divisions than cable intervals.
    """
    stations, pulls = layout.stations, list[Array]()
    ring = frame_points(layout, stations)
    for own, pull in zip(stations, (pretension_y, pretension_x), strict=True):
        tension = np.full(len(own), pull)
        if layout.distribution == "tributary":
            tension[[0, -1]] *= 0.5
        pulls.append(tension)
    return framed(
        layout,
        film_mesh(layout, stations),
        ring,
        straight_cables(layout, stations, (pulls[0], pulls[1])),
        sections=(membrane, cable, frame),
        membrane_stress=membrane_stress,
        prestress_mode=prestress_mode,
    )


def straight_cables(layout: AntennaLayout, stations: Stations, tensions: tuple[Array, Array]) -> tuple[Array, Array]:
    """Cables from the stations of the film's edges straight to the frame.

    Parameters
    ----------
    layout
        Geometry, with a frame.
    stations
        Where they stand.
    tensions
        Of the cable at each station of the long edges, along y, and of the short ones, along x [N].

    Returns
    -------
    ends
        Their points on film and frame [m], shape (cable, 2, 2).
    tension
        Theirs [N], shape (cable,).
    """
    film, frame = (layout.length, layout.width), layout.frame_sides
    ends, tension = [], []
    for axis in (1, 0):
        for station, pull in zip(stations[1 - axis], tensions[1 - axis], strict=True):
            for part in (-0.5, 0.5):
                sides = (part * film[axis], part * frame[axis])
                ends.append([(station, side) if axis == 1 else (side, station) for side in sides])
                tension.append(pull)
    return np.array(ends), np.array(tension)


def framed(
    layout: AntennaLayout,
    film: tuple[Array, Indices],
    ring: Array,
    cables: tuple[Array, Array],
    *,
    sections: tuple[MembraneSection, CableSection, BeamSection],
    membrane_stress: tuple[float, float, float],
    prestress_mode: str,
) -> Model:
    """Film of given nodes and elements in its frame, held by cables of given ends and tensions."""
    film_nodes, elements = film
    ends, tension = cables
    first = len(film_nodes)
    lines = np.array([(_nearest(film_nodes, inner), first + _nearest(ring, outer)) for inner, outer in ends])
    beams = np.column_stack([np.arange(len(ring)), np.roll(np.arange(len(ring)), -1)]) + first
    nodes = np.concatenate([film_nodes, np.column_stack([ring, np.zeros(len(ring))])])
    nodes, lines = _split(nodes, lines, layout.cable_segments)
    held = first + np.flatnonzero(_held_frame_points(layout, ring))
    membrane, cable, frame = sections
    return Model.from_mesh(
        nodes,
        surfaces={layout.element: elements},
        membrane=membrane,
        membrane_stress=membrane_stress,
        cables=lines,
        cable=cable,
        cable_tension=np.repeat(tension, layout.cable_segments),
        beams=beams,
        beam=frame,
        supports=(Support.clamped(held),) if held.size else (),
        prestress_mode=prestress_mode,
    )


def _split(nodes: Array, lines: Indices, count: int) -> tuple[Array, Indices]:
    """Lines (line, 2) cut into so many of equal length, one after the other, and all nodes."""
    inner = len(nodes) + np.arange(len(lines) * (count - 1)).reshape(len(lines), count - 1)
    shares = (np.arange(1, count) / count)[None, :, None]
    start, end = nodes[lines[:, :1]], nodes[lines[:, 1:]]
    chain = np.concatenate([lines[:, :1], inner, lines[:, 1:]], axis=1)
    pieces = np.stack([chain[:, :-1], chain[:, 1:]], axis=2).reshape(-1, 2)
    return np.concatenate([nodes, (start + shares * (end - start)).reshape(-1, 3)]), pieces


def film_mesh(layout: AntennaLayout, stations: Stations) -> tuple[Array, Indices]:
    """Nodes and elements of the film, with a node at every station of its edges."""
    shape = surface_shape("element", layout.element)
    lines_x = graded_lines(layout.length, layout.divisions[0], stations[0], shape)
    lines_y = graded_lines(layout.width, layout.divisions[1], stations[1], shape)
    return rectangle_mesh(lines_x, lines_y, layout.pattern, shape)


def _nearest(nodes: Array, point: Array) -> int:
    return int(np.argmin((nodes[:, 0] - point[0]) ** 2 + (nodes[:, 1] - point[1]) ** 2))


def frame_points(layout: AntennaLayout, stations: Stations) -> Array:
    """Frame nodes counter-clockwise from the lower left corner: corners, cable ends, points on the x axis.

    InputError if the layout has no frame around the film.
    """
    half_x, half_y = (0.5 * side for side in layout.frame_sides)
    on_axis = [0.0] if layout.support == "axis" else []
    side_y = np.unique(np.round(np.concatenate([[-half_y], stations[1], on_axis]), 12))
    side_x = np.unique(np.round(np.concatenate([[-half_x], stations[0]]), 12))
    corner_y, corner_x = np.append(side_y, half_y), np.append(side_x, half_x)
    return np.concatenate(
        [
            np.column_stack([corner_x[:-1], np.full(len(side_x), -half_y)]),
            np.column_stack([np.full(len(side_y), half_x), corner_y[:-1]]),
            np.column_stack([corner_x[:0:-1], np.full(len(side_x), half_y)]),
            np.column_stack([np.full(len(side_y), -half_x), corner_y[:0:-1]]),
        ]
    )


def _held_frame_points(layout: AntennaLayout, ring: Array) -> Mask:
    """Mark the frame nodes that the layout's support clamps."""
    length, width = layout.frame_sides
    close = 1e-9 * length
    at_short = np.abs(np.abs(ring[:, 0]) - 0.5 * length) < close
    at_long = np.abs(np.abs(ring[:, 1]) - 0.5 * width) < close
    held = {
        "corners": at_short & at_long,
        "all": np.ones(len(ring), dtype=bool),
        "axis": at_short & (np.abs(ring[:, 1]) < close),
        "short-side": at_short,
        "free": np.zeros(len(ring), dtype=bool),
    }
    return held[layout.support]
