"""Properties of a Nastran deck as sections of films, cables and beams."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from tautflex.errors import InputError, MeshError
from tautflex.files.mesh.nastran.materials import MATERIALS, Materials
from tautflex.files.mesh.nastran.text import Card
from tautflex.files.mesh.numerals import natural, real, vector
from tautflex.files.mesh.raw import shorten
from tautflex.files.mesh.section.profiles import Profile, Wall, box, double_tee, rectangle, tube, walls
from tautflex.files.mesh.section.section_data import RawSection

KINDS = {
    **dict.fromkeys(("PSHELL", "PCOMP", "PCOMPG"), "membrane"),
    **dict.fromkeys(("PROD", "PTUBE"), "cable"),
    **dict.fromkeys(("PBAR", "PBARL", "PBEAM", "PBEAML", "PBRSECT", "PBMSECT", "PBCOMP"), "beam"),
}
PROPERTIES = (*KINDS, *MATERIALS)
_BEAM = ("area", "inertia_z", "inertia_y", "torsion_constant")
_STATION = 16  # fields of one station of a PBEAM, its points of stress recovery among them


def _i(height: float, low: float, high: float, web: float, under: float, over: float) -> Profile:
    upright = Wall(0.5 * (under - over), 0.0, height - under - over, web, 0.5 * (under + over))
    return walls(upright, Wall(0.5 * (under - height), 0.0, under, low), Wall(0.5 * (height - over), 0.0, over, high))


def _channel(width: float, height: float, web: float, flange: float) -> Profile:
    middle = 0.5 * (height - flange), 0.5 * (width - web)
    upper, lower = (Wall(side * middle[0], middle[1], flange, width, -0.5 * web) for side in (1.0, -1.0))
    return walls(upper, Wall(0.0, 0.0, height - 2.0 * flange, web, flange), lower)


def _lying(profile: Profile) -> Profile:
    return profile._replace(inertia_y=profile.inertia_z, inertia_z=profile.inertia_y)


def _tee(width: float, height: float, flange: float, web: float) -> Profile:
    return walls(Wall(0.0, 0.0, flange, width), Wall(0.5 * height, 0.0, height - flange, web, 0.5 * flange))


def _cross(arms: float, upright: float, height: float, thickness: float) -> Profile:
    side = 0.25 * arms + 0.5 * upright
    outer = (Wall(0.0, z, thickness, 0.5 * arms, 0.5 * upright) for z in (-side, side))
    return walls(Wall(0.0, 0.0, height, upright), *outer)


def _h(clear: float, legs: float, height: float, bar: float) -> Profile:
    side = 0.5 * clear + 0.25 * legs
    outer = (Wall(0.0, z, height, 0.5 * legs) for z in (-side, side))
    return walls(Wall(0.0, 0.0, bar, clear, 0.5 * legs), *outer)


def _hat(height: float, wall: float, top: float, brim: float) -> Profile:
    middle = 0.5 * (top - wall)
    sides = (Wall(0.5 * (wall - height), z, height - 2.0 * wall, wall, wall) for z in (-middle, middle))
    out = middle + 0.5 * brim
    brims = (Wall(wall - height, z, wall, brim + wall, -0.5 * wall) for z in (-out, out))
    return walls(Wall(0.0, 0.0, wall, top, -wall), *sides, *brims)


# Local y is up in the figures of PBARL, local z is across.
_PROFILES: dict[str, tuple[int, Callable[..., Profile]]] = {
    "ROD": (1, tube),
    "TUBE": (2, lambda outer, inner: tube(outer, outer - inner)),
    "TUBE2": (2, tube),
    "BAR": (2, lambda across, up: rectangle(up, across)),
    "BOX": (4, lambda across, up, flange, web: box(up, across, flange, web)),
    "I": (6, _i),
    "I1": (4, lambda flange, web, clear, height: double_tee(height, flange + web, web, 0.5 * (height - clear))),
    "CHAN": (4, _channel),
    "CHAN1": (4, lambda flange, web, clear, height: _channel(flange + web, height, web, 0.5 * (height - clear))),
    "CHAN2": (4, lambda leg, web, height, width: _lying(_channel(height, width, web, leg))),
    "T": (4, _tee),
    "T1": (4, lambda height, stem, flange, web: _lying(_tee(height, stem + flange, flange, web))),
    "T2": (4, _tee),
    "CROSS": (4, _cross),
    "H": (4, _h),
    "HAT": (4, _hat),
}
# Their centroid is beside their shear centre, which a CBEAM keeps apart and a CBAR does not.
_ONE_SIDED = ("CHAN", "CHAN1", "CHAN2", "T", "T1", "T2", "HAT")


@dataclass
class Properties:
    """What property and material cards have brought."""

    cards: dict[int, list[Card]] = field(default_factory=dict)
    materials: Materials = field(default_factory=Materials)

    def read(self, card: Card) -> None:
        """Keep a card."""
        if card.name in MATERIALS:
            self.materials.read(card)
        else:
            self.cards.setdefault(natural(card.get(1), card.where), []).append(card)

    def sections(self, number: int, factor: float) -> Iterator[RawSection]:
        """Sections of a property, their masses times ``factor``; MeshError if two are of the same kind."""
        kinds: dict[str, Card] = {}
        for card in self.cards.get(number, ()):
            kind = KINDS[card.name]
            if kind in kinds:
                raise MeshError(f"{card.where}: property {number} is defined twice; give it its own number")
            kinds[kind] = card
            values, doubt = _READERS[card.name](card)
            material = "" if card.name.startswith("PCOMP") else card.get(2)
            yield self._section(card, kind, material, values, doubt, factor)

    def expansion(self, owner: str, kind: str, where: str) -> tuple[float, float]:
        """Coefficient of expansion and temperature of reference of a property's elements, or of ``M<material>``."""
        if owner.startswith("M"):
            return self.materials.expansion(owner[1:], where)
        cards = [card for card in self.cards.get(int(owner), ()) if KINDS[card.name] == kind]
        if not cards or _READERS[cards[0].name] in (_laminate, _unread):
            raise MeshError(
                f"{where}: expected a property of one material beside temperatures, got {owner}; state the prestress "
                "in the case, and leave TEMPERATURE out of the case control"
            )
        return self.materials.expansion(cards[0].get(2), where)

    def rod(self, card: Card, factor: float) -> RawSection:
        """Section that a CONROD states itself."""
        values = {"area": real(card.get(5), card.where), "nonstructural_mass": real(card.get(8), card.where)}
        return self._section(card, "cable", card.get(4), values, "", factor)

    def _section(
        self, card: Card, kind: str, material: str, values: dict[str, float], doubt: str, factor: float
    ) -> RawSection:
        of_material, other = self.materials.values(material, kind, card.where)
        found = {name: value for name, value in {**values, **of_material}.items() if value}
        for name in ("density", "nonstructural_mass"):
            if name in found:
                found[name] *= factor
        return RawSection(card.where, kind, found, doubt or other)


def _filled(card: Card, *places: int) -> str:
    """Doubt about fields that are filled and not read."""
    for place in places:
        if real(card.get(place), card.where):
            return f"its field {place + 1 + 2 * ((place - 1) // 8)} = {shorten(card.get(place))} is not read here"
    return ""


def _numbers(card: Card, **places: int) -> dict[str, float]:
    return {name: real(card.get(place), card.where) for name, place in places.items()}


def _pshell(card: Card) -> tuple[dict[str, float], str]:
    return _numbers(card, thickness=3, nonstructural_mass=8), _filled(card, 11)


def _laminate(card: Card) -> tuple[dict[str, float], str]:
    return {}, f"{card.name} is a laminate, expected PSHELL with MAT1"


def _prod(card: Card) -> tuple[dict[str, float], str]:
    return _numbers(card, area=3, nonstructural_mass=6), ""


def _ptube(card: Card) -> tuple[dict[str, float], str]:
    outer, wall = vector([card.get(3), card.get(4)], card.where).tolist()
    radius = 0.5 * outer
    values = _numbers(card, nonstructural_mass=5)
    if card.get(6) and real(card.get(6), card.where) != 2.0 * radius:
        return values, "it tapers"
    return _of_profile(card, values, tube, [radius, wall] if wall else [radius], ("area",))


def _pbar(card: Card) -> tuple[dict[str, float], str]:
    values = _numbers(card, area=3, inertia_z=4, inertia_y=5, torsion_constant=6, nonstructural_mass=7)
    return values, _filled(card, 19)


def _of_profile(
    card: Card,
    values: dict[str, float],
    profile: Callable[..., Profile],
    sizes: list[float],
    kept: tuple[str, ...] = _BEAM,
) -> tuple[dict[str, float], str]:
    try:
        found = profile(*sizes)._asdict()
    except InputError as error:
        return values, str(error)
    return {**{name: found[name] for name in kept}, **values}, ""


def _profiled(card: Card) -> tuple[dict[str, float], str]:
    """PBARL and PBEAML: dimensions by name, those of PBEAML again at other stations, where they must be the same."""
    name = card.get(4).upper()
    if name not in _PROFILES:
        return {}, f"its cross-section is {shorten(name)}, expected {', '.join(_PROFILES)}; write it as PBAR"
    count, profile = _PROFILES[name]
    numbers = [card.get(place) for place in range(9, 10 + count)]
    *sizes, nonstructural = vector(numbers, card.where).tolist()
    values = {"nonstructural_mass": nonstructural}
    flanges = name == "I" and (sizes[1], sizes[4]) != (sizes[2], sizes[5])
    if card.name == "PBEAML" and (flanges or name in _ONE_SIDED):
        return {}, f"its centroid is beside its shear centre ({name}), which is not read here; write it as PBARL"
    rest = card.fields[9 + count :]
    if card.name == "PBARL" and any(rest):
        return {}, f"{name} has {count} dimensions and a mass, got more"
    for start in range(0, len(rest), count + 3) if card.name == "PBEAML" else ():
        other = rest[start + 2 : start + 3 + count]
        if any(
            text and real(text, card.where) != real(same, card.where)
            for text, same in zip(other, numbers, strict=False)
        ):
            return {}, "it tapers"
    return _of_profile(card, values, profile, sizes)


def _pbeam(card: Card) -> tuple[dict[str, float], str]:
    """Section at the first end; others must be the same, and have no offsets or warping."""
    values = _numbers(card, area=3, inertia_z=4, inertia_y=5, torsion_constant=7, nonstructural_mass=8)
    doubt, rest = _filled(card, 6), card.fields[_STATION:]
    while rest and rest[0].upper() in ("YES", "YESA", "NO"):
        own = [real(text, card.where) for text in rest[2:8] if text]
        at_first = [real(card.get(place), card.where) for place in range(3, 9) if rest[place - 1 : place] != [""]]
        if own != at_first[: len(own)]:
            doubt = doubt or "it tapers"
        rest = rest[_STATION if rest[0].upper() == "YES" else _STATION // 2 :]
    if any(real(text, card.where) for text in rest[2:]):
        doubt = doubt or "its shear relief, warping or offsets are not read here"
    return values, doubt


def _unread(card: Card) -> tuple[dict[str, float], str]:
    return {}, f"{card.name} is not read here, expected PBAR or PBARL"


_READERS: dict[str, Callable[[Card], tuple[dict[str, float], str]]] = {
    "PSHELL": _pshell,
    **dict.fromkeys(("PCOMP", "PCOMPG"), _laminate),
    "PROD": _prod,
    "PTUBE": _ptube,
    "PBAR": _pbar,
    **dict.fromkeys(("PBARL", "PBEAML"), _profiled),
    "PBEAM": _pbeam,
    **dict.fromkeys(("PBRSECT", "PBMSECT", "PBCOMP"), _unread),
}
