"""Section blocks of an Abaqus file as sections of films, cables and beams."""

from __future__ import annotations

import re
from collections.abc import Callable

from tautflex.errors import InputError
from tautflex.files.mesh.abaqus.materials import Materials
from tautflex.files.mesh.abaqus.text import Block, fields
from tautflex.files.mesh.numerals import finite, vector
from tautflex.files.mesh.raw import shorten
from tautflex.files.mesh.section.profiles import Profile, box, double_tee, rectangle, tube
from tautflex.files.mesh.section.section_data import RawSection

KINDS = {
    "MEMBRANE SECTION": "membrane",
    "SHELL SECTION": "membrane",
    "SHELL GENERAL SECTION": "membrane",
    "SOLID SECTION": "cable",
    "BEAM SECTION": "beam",
    "BEAM GENERAL SECTION": "beam",
}
# ORIENTATION turns the axes of an isotropic material, the others are about how stiffness is integrated.
_OPTIONS = ("ELSET", "MATERIAL", "SECTION", "ORIENTATION", "CONTROLS", "TEMPERATURE", "SECTION INTEGRATION", "ROTATION")
_OF_BEAMS = (*_OPTIONS, "POISSON", "DENSITY")

_LARGEST = 1e9  # [in the file's unit]; powers of it stay finite


def _box(along_1: float, along_2: float, *walls: float) -> Profile:
    if len(set(walls)) > 1:
        raise InputError("cross-section: expected walls of one thickness, got others; write it as GENERAL")
    return box(along_1, along_2, walls[0], walls[0])


def _tee(offset: float, height: float, low: float, high: float, under: float, over: float, web: float) -> Profile:
    if low != high or under != over or 2.0 * offset != height:
        raise InputError("cross-section: expected a symmetric I about its middle, got another; write it as GENERAL")
    upright = double_tee(height, low, web, under)
    return upright._replace(inertia_y=upright.inertia_z, inertia_z=upright.inertia_y)


# Dimensions of each cross-section; n1 is local y, the height of an I runs along n2.
_PROFILES: dict[str, tuple[int, Callable[..., Profile]]] = {
    "CIRC": (1, tube),
    "PIPE": (2, tube),
    "THICK PIPE": (2, tube),
    "RECT": (2, rectangle),
    "BOX": (6, _box),
    "I": (7, _tee),
}


def section(block: Block, materials: Materials) -> RawSection:
    """Section that a block gives its elements; what it cannot be had of is its doubt.

    Raises
    ------
    MeshError
        If a number cannot be read.
    """
    kind, name = KINDS[block.keyword], block.option("MATERIAL").casefold()
    if "COMPOSITE" in block.options:
        return RawSection(block.where, kind, {}, "it is a laminate, expected one material")
    general = block.keyword == "BEAM GENERAL SECTION"
    # Behind the direction of a beam stand the counts of points at which it is integrated, of a general one its moduli.
    counted = "." not in "".join(line for _, line in block.lines[2:])
    known = 1 if kind != "beam" else 3 if general or counted else 2
    doubt = "it has lines that are not read here" if len(block.lines) > known else ""
    for option in block.options:
        centred = option == "OFFSET" and re.fullmatch(r"[-+]?0*\.?0*(e[-+]?\d+)?", block.option(option), re.IGNORECASE)
        if option not in (_OF_BEAMS if kind == "beam" else _OPTIONS) and not centred:
            doubt = f"option {shorten(option)} is not read here"
    if name:
        unknown = "" if name in materials.values else f"its material {shorten(name)} is not in the file"
        doubt = doubt or unknown or materials.doubts.get(name, "")
    numbers = [vector(fields(line), where, largest=1e300).tolist() for where, line in block.lines]
    first = numbers[0] if numbers else []
    values = dict(materials.values.get(name, {}))
    if kind == "membrane":
        values["thickness"] = first[0] if first else 0.0
        if block.keyword == "SHELL GENERAL SECTION" and not name:
            doubt = doubt or "it states stiffnesses, expected a MATERIAL and a thickness"
    elif kind == "cable":
        values["area"] = first[0] if first and first[0] else 1.0  # the format's default
    else:
        shape = " ".join(block.option("SECTION").upper().split())
        if general and block.option("DENSITY"):
            values["density"] = finite(block.option("DENSITY"), block.where)
        if general and len(numbers) > 2:
            young, shear = (numbers[2] + [0.0, 0.0])[:2]
            values |= {"youngs_modulus": young, **({"poisson_ratio": 0.5 * young / shear - 1.0} if shear else {})}
            if len(numbers[2]) > 2 and any(numbers[2][2:]):
                doubt = doubt or "its expansion is not read here"
        profile, why = _profile(shape or ("GENERAL" if general else ""), first)
        values, doubt = {**values, **profile}, doubt or why
    return RawSection(block.where, kind, {key: value for key, value in values.items() if value}, doubt)


def _profile(shape: str, sizes: list[float]) -> tuple[dict[str, float], str]:
    """Area, moments and torsion of a cross-section, and why they cannot be had."""
    if shape == "GENERAL":
        area, about_1, product, about_2, torsion, *warping = [*sizes, *[0.0] * (5 - len(sizes))]
        found = Profile(area, about_1, about_2, torsion)._asdict()
        return found, "I12 and warping are not read here" if product or any(warping) else ""
    count, profile = _PROFILES.get(shape, (0, tube))
    if not count:
        return {}, f"its cross-section is {shorten(shape)}, expected {', '.join(_PROFILES)} or GENERAL"
    if len(sizes) != count:
        return {}, f"its cross-section {shape} has {len(sizes)} dimensions, expected {count}"
    if max(map(abs, sizes)) > _LARGEST:
        return {}, f"its cross-section has dimensions beyond {_LARGEST:g}"
    try:
        return profile(*sizes)._asdict(), ""
    except InputError as error:
        return {}, str(error)
