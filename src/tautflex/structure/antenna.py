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

    def __post_init__(self) -> None:
        checks.positive("length", self.length)
        checks.positive("width", self.width)
        checks.one_of("support", self.support, FRAME_SUPPORTS)
        checks.one_of("distribution", self.distribution, DISTRIBUTIONS)
        surface_shape("element", self.element)
        if (self.frame_length is None) != (self.frame_width is None):
            raise InputError("frame_length, frame_width: expected both or neither; give the missing one")
        if min(self.divisions) < 1:
            raise InputError(f"divisions: expected two integers >= 1, got {self.divisions}")


def build_fixed_film(layout: AntennaLayout, membrane: MembraneSection, stress: tuple[float, float, float]) -> Model:
    """Rectangular film with all four edges fixed under a given uniform stress (sx, sy, txy) [Pa]."""
    ends = 0.5 * np.array([layout.length, layout.width])
    nodes, elements = _film(layout, *np.outer(ends, [-1.0, 1.0]))
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
    if layout.frame_length is None or layout.frame_width is None:
        raise InputError("layout: expected frame_length and frame_width, got None; use build_fixed_film instead")
    if layout.frame_length <= layout.length or layout.frame_width <= layout.width:
        raise InputError("layout: expected a frame larger than the film on both sides; enlarge the frame")
    stations_x = np.linspace(-0.5, 0.5, layout.cables_per_long_edge) * layout.length
    stations_y = np.linspace(-0.5, 0.5, layout.cables_per_short_edge) * layout.width
    film_nodes, elements = _film(layout, stations_x, stations_y)
    ring = _frame_points(layout, stations_x, stations_y)
    first = len(film_nodes)
    cables, tension = [], []
    for stations, axis, pull in ((stations_x, 1, pretension_y), (stations_y, 0, pretension_x)):
        sides = (layout.width, layout.frame_width) if axis == 1 else (layout.length, layout.frame_length)
        for station in stations:
            shared = layout.distribution == "tributary" and station in (stations[0], stations[-1])
            for part in (-0.5, 0.5):
                inner, outer = ((station, part * side) if axis == 1 else (part * side, station) for side in sides)
                cables.append((_nearest(film_nodes, inner), first + _nearest(ring, outer)))
                tension.append(0.5 * pull if shared else pull)
    beams = np.column_stack([np.arange(len(ring)), np.roll(np.arange(len(ring)), -1)]) + first
    frame_nodes = np.column_stack([ring, np.zeros(len(ring))])
    held = first + np.flatnonzero(_held_frame_points(layout, ring))
    return Model.from_mesh(
        np.concatenate([film_nodes, frame_nodes]),
        surfaces={layout.element: elements},
        membrane=membrane,
        membrane_stress=membrane_stress,
        cables=np.array(cables),
        cable=cable,
        cable_tension=np.array(tension),
        beams=beams,
        beam=frame,
        supports=(Support.clamped(held),) if held.size else (),
        prestress_mode=prestress_mode,
    )


def _film(layout: AntennaLayout, stations_x: Array, stations_y: Array) -> tuple[Array, Indices]:
    """Nodes and elements of the film, with a node at every station of its edges."""
    shape = surface_shape("element", layout.element)
    lines_x = graded_lines(layout.length, layout.divisions[0], stations_x, shape)
    lines_y = graded_lines(layout.width, layout.divisions[1], stations_y, shape)
    return rectangle_mesh(lines_x, lines_y, layout.pattern, shape)


def _nearest(nodes: Array, point: tuple[float, float]) -> int:
    return int(np.argmin((nodes[:, 0] - point[0]) ** 2 + (nodes[:, 1] - point[1]) ** 2))


def _frame_points(layout: AntennaLayout, stations_x: Array, stations_y: Array) -> Array:
    """Frame nodes counter-clockwise from the lower left corner: corners, cable ends, points on the x axis."""
    assert layout.frame_length is not None
    assert layout.frame_width is not None
    half_x, half_y = 0.5 * layout.frame_length, 0.5 * layout.frame_width
    on_axis = [0.0] if layout.support == "axis" else []
    side_y = np.unique(np.round(np.concatenate([[-half_y], stations_y, on_axis]), 12))
    side_x = np.unique(np.round(np.concatenate([[-half_x], stations_x]), 12))
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
    assert layout.frame_length is not None
    assert layout.frame_width is not None
    close = 1e-9 * layout.frame_length
    at_short = np.abs(np.abs(ring[:, 0]) - 0.5 * layout.frame_length) < close
    at_long = np.abs(np.abs(ring[:, 1]) - 0.5 * layout.frame_width) < close
    held = {
        "corners": at_short & at_long,
        "all": np.ones(len(ring), dtype=bool),
        "axis": at_short & (np.abs(ring[:, 1]) < close),
        "short-side": at_short,
        "free": np.zeros(len(ring), dtype=bool),
    }
    return held[layout.support]
