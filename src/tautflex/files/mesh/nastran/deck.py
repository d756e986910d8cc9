"""A Nastran deck as a mesh."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.include import Folder, expanded, numbered_lines
from tautflex.files.mesh.nastran.cards import WORDS
from tautflex.files.mesh.nastran.case_control import bulk_and_selection
from tautflex.files.mesh.nastran.coordinates import Systems
from tautflex.files.mesh.nastran.elements import Elements
from tautflex.files.mesh.nastran.joints.links import LINKS, Links
from tautflex.files.mesh.nastran.joints.springs import SPRINGS, Springs
from tautflex.files.mesh.nastran.masses import MASSES, Masses
from tautflex.files.mesh.nastran.nonstructural import NONSTRUCTURAL, Nonstructural
from tautflex.files.mesh.nastran.properties import PROPERTIES, Properties
from tautflex.files.mesh.nastran.supports import Supports, components, held_groups
from tautflex.files.mesh.nastran.temperatures import TEMPERATURES, Temperatures
from tautflex.files.mesh.nastran.text import Card, cards, included
from tautflex.files.mesh.numerals import natural, vector
from tautflex.files.mesh.raw import RawMesh, integers
from tautflex.files.mesh.second_order import simplified
from tautflex.numeric import Array, Indices

# Cards that would count twice if a file is included twice; of other elements it is found with their numbering.
_NUMBERED = (
    *("CONM1", "CONM2", "CMASS1", "CMASS2", "RBE1", "RBE2", "RBE3", "RBAR"),
    *("CELAS1", "CELAS2", "CBUSH", "CDAMP1", "CDAMP2", "CVISC"),
)


def read_nastran(text: str, folder: Folder | None = None, step: int | None = None) -> RawMesh:
    """Read the mesh of a Nastran deck.

    Elements are in the group ``pid<N>`` of their property, constraints in ``spc<N>`` of their set.

    Parameters
    ----------
    text
        The deck.
    folder
        Where included files are.
    step
        Number of the subcase whose supports hold; None if all have the same.

    Raises
    ------
    MeshError
        If a card is wrong, or would change the structure and is not read.
    """
    lines = expanded(numbered_lines(text), folder or Folder(), included)
    bulk, selection = bulk_and_selection(lines, step)
    deck = _Deck()
    for card in cards(bulk):
        if WORDS.is_read(card.name, card.where):
            card.require_right()
            deck.read(card)
    deck.elements.finish()
    points, nodes = deck.positions(), deck.elements.nodes("grid point")
    connectivity = deck.elements.connectivity(nodes)
    links = [
        *deck.links.links(selection, nodes, deck.axes),
        *deck.springs.springs(nodes, deck.point, deck.axes, deck.systems),
    ]
    joined = [connectivity[shape].ravel() for shape in connectivity] + [integers(one.link.joined) for one in links]
    groups = [
        *deck.elements.groups(deck.properties, deck.masses.factor or 1.0),
        *deck.nonstructural.groups(selection, deck.elements, deck.masses.factor or 1.0),
        *held_groups("grid", deck.held_points(np.concatenate(joined)), nodes, deck.axes),
        *deck.supports.groups(selection, nodes, deck.axes),
    ]
    roles = {shape: np.array(own, dtype="<U8") for shape, own in deck.elements.roles.items()}
    orientation = deck.elements.orientations(deck.point, deck.turned)
    masses = [
        replace(body, node=int(nodes.rows(integers([number]), body.where)[0]))
        for number, body in deck.masses.bodies(deck.systems, deck.point, deck.axes)
    ]
    connectivity["line2"], ends = deck.elements.moved_ends(points, connectivity["line2"], orientation, deck.turned)
    points = np.reshape(ends.points, (-1, 3))
    lengths = np.linalg.norm(np.diff(points[connectivity["line2"]], axis=1)[:, 0], axis=1)
    strain = deck.temperatures.strain(selection, deck.elements, deck.properties, lengths)
    joined_all = [*ends.links, *links]
    return simplified(points, connectivity, roles, orientation, groups, True, masses, joined_all, None, strain)


@dataclass
class _Deck:
    """What the cards read so far have brought."""

    elements: Elements = field(default_factory=Elements)
    supports: Supports = field(default_factory=Supports)
    masses: Masses = field(default_factory=Masses)
    properties: Properties = field(default_factory=Properties)
    links: Links = field(default_factory=Links)
    springs: Springs = field(default_factory=Springs)
    nonstructural: Nonstructural = field(default_factory=Nonstructural)
    temperatures: Temperatures = field(default_factory=Temperatures)
    grid: dict[int, Card] = field(default_factory=dict)
    point_defaults: Card | None = None
    numbered: set[tuple[str, int]] = field(default_factory=set)

    def __post_init__(self) -> None:
        self.systems = Systems(self.point)
        self._positions: dict[int, Array] = {}

    def read(self, card: Card) -> None:
        if card.name in _NUMBERED:
            label = card.name, natural(card.get(1), card.where)
            if label in self.numbered:
                raise MeshError(f"{card.where}: {card.name} {label[1]} is defined twice; give it its own number")
            self.numbered.add(label)
        if card.name == "GRID":
            card.require_only(*range(1, 8))
            number = natural(card.get(1), card.where)
            self.elements.node_numbers.append(number)  # one that is there twice is found with the numbering
            self.grid[number] = card
        elif card.name == "GRDSET":
            card.require_only(2, 6, 7)
            if self.point_defaults is not None:
                raise MeshError(f"{card.where}: expected one GRDSET, got a second one; remove it")
            self.point_defaults = card
        elif card.name.startswith("CORD"):
            self.systems.add(card)
        elif card.name.startswith("SPC"):
            self.supports.read(card)
        elif card.name in MASSES:
            self.masses.read(card)
        elif card.name in PROPERTIES:
            self.properties.read(card)
            if card.name in ("PSHELL", "PCOMP", "PCOMPG"):
                self.elements.read(card)
        elif card.name in NONSTRUCTURAL:
            self.nonstructural.read(card)
        elif card.name in TEMPERATURES:
            self.temperatures.read(card)
        elif card.name in LINKS:
            self.links.read(card)
        elif card.name in SPRINGS:
            self.springs.read(card)
        else:
            self.elements.read(card)

    def _field(self, card: Card, place: int) -> str:
        default = self.point_defaults
        return card.get(place) or ("" if default is None else default.get(place))

    def point(self, number: int, where: str) -> Array:
        """Position of a grid point in basic coordinates."""
        if number not in self._positions:
            card = self.grid.get(number)
            if card is None:
                raise MeshError(f"{where}: expected an existing grid point, got {number}; define it")
            given = vector([card.get(place) for place in (3, 4, 5)], card.where)
            system = self._field(card, 2)
            self._positions[number] = (
                given if system in ("", "0") else self.systems.named(system, card.where).position(given)
            )
        return self._positions[number]

    def positions(self) -> Array:
        """Positions of all grid points in basic coordinates, shape (point, 3)."""
        numbers = self.elements.node_numbers
        return np.array([self.point(number, f"grid point {number}") for number in numbers]).reshape(-1, 3)

    def axes(self, number: int) -> Array | None:
        """Directions of the displacement system of a grid point as rows, None where they are global."""
        self.point(number, f"grid point {number}")
        card = self.grid[number]
        system = self._field(card, 6)
        if system in ("", "0"):
            return None
        return self.systems.named(system, card.where).directions(self.point(number, card.where))

    def turned(self, number: int, vector: Array, where: str) -> Array:
        """Vector of the displacement system of a grid point in basic coordinates."""
        axes = self.axes(number)
        return vector if axes is None else np.asarray(vector @ axes)

    def held_points(self, joined: Indices) -> dict[int, set[int]]:
        """Permanent constraints of points that belong to an element or a link, given their rows."""
        used = set(joined.tolist())
        held = {}
        for row, number in enumerate(self.elements.node_numbers):
            card = self.grid[number]
            if row in used and (text := self._field(card, 7)) not in ("", "0"):
                held[number] = components(text, card.where)
        return held
