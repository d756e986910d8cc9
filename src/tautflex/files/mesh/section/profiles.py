"""Areas, second moments and torsion constants of cross-sections whose principal axes are local y and z."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tautflex.errors import InputError


class Profile(NamedTuple):
    """Area [m^2], second moments about local y and z [m^4] and torsion constant [m^4] of a cross-section."""

    area: float
    inertia_y: float
    inertia_z: float
    torsion_constant: float


def tube(radius: float, thickness: float | None = None) -> Profile:
    """Circular tube of an outer radius [m]; a solid rod without ``thickness``.

    Raises
    ------
    InputError
        If the tube has no wall, or a wall thicker than its radius.
    """
    inner = 0.0 if thickness is None else radius - thickness
    _require(0.0 <= inner < radius, f"a radius > 0 and a wall no thicker than it, got {radius:g} and {thickness}")
    moment = 0.25 * np.pi * (radius**4 - inner**4)
    return Profile(np.pi * (radius**2 - inner**2), moment, moment, 2.0 * moment)


def rectangle(along_y: float, along_z: float) -> Profile:
    """Solid rectangle of two sides [m]; its torsion constant is Saint-Venant's series [Timoshenko and Goodier 109].

    Raises
    ------
    InputError
        If a side is not > 0.
    """
    _require(min(along_y, along_z) > 0.0, f"sides > 0, got {along_y:g} and {along_z:g}")
    long, short = max(along_y, along_z), min(along_y, along_z)
    odd = np.arange(1, 40, 2)
    series = float(np.sum(np.tanh(0.5 * np.pi * odd * min(long / short, 100.0)) / odd**5))
    torsion = long * short**3 / 3.0 * (1.0 - 192.0 / np.pi**5 * short / long * series)
    return Profile(along_y * along_z, along_y * along_z**3 / 12.0, along_z * along_y**3 / 12.0, torsion)


def box(along_y: float, along_z: float, wall_y: float, wall_z: float) -> Profile:
    """Hollow rectangle; ``wall_y`` is the thickness of the walls across y, ``wall_z`` of those across z [m] [Bredt].

    Raises
    ------
    InputError
        If the walls leave no hollow.
    """
    inside_y, inside_z = along_y - 2.0 * wall_y, along_z - 2.0 * wall_z
    _require(
        min(wall_y, wall_z, inside_y, inside_z) > 0.0,
        f"a hollow inside walls, got {along_y:g} x {along_z:g} with walls {wall_y:g} and {wall_z:g}",
    )
    middle_y, middle_z = along_y - wall_y, along_z - wall_z
    torsion = 2.0 * (middle_y * middle_z) ** 2 / (middle_y / wall_z + middle_z / wall_y)
    return Profile(
        along_y * along_z - inside_y * inside_z,
        (along_y * along_z**3 - inside_y * inside_z**3) / 12.0,
        (along_z * along_y**3 - inside_z * inside_y**3) / 12.0,
        torsion,
    )


class Wall(NamedTuple):
    """Rectangle of an open cross-section [m]: its middle, its sides, and how far its midline runs on into others."""

    y: float
    z: float
    along_y: float
    along_z: float
    onward: float = 0.0


def walls(*parts: Wall) -> Profile:
    """Open cross-section of rectangles, symmetric about y or z, about its centroid.

    Its torsion constant is that of thin walls, ``sum of b t^3 / 3`` over their midlines [Timoshenko and Goodier 112].

    Raises
    ------
    InputError
        If a side is not > 0.
    """
    y, z, along_y, along_z, onward = np.transpose(parts)
    shortest = float(min(along_y.min(), along_z.min()))
    _require(shortest > 0.0, f"walls with sides > 0, got one of {shortest:g}")
    areas, thickness = along_y * along_z, np.minimum(along_y, along_z)
    area = areas.sum()
    y, z = y - areas @ y / area, z - areas @ z / area
    moments = [areas @ (along_z**2 / 12.0 + z**2), areas @ (along_y**2 / 12.0 + y**2)]
    return Profile(*map(float, (area, *moments, (np.maximum(along_y, along_z) + onward) @ thickness**3 / 3.0)))


def double_tee(height: float, width: float, web: float, flange: float) -> Profile:
    """I section of two equal flanges along z and a web along y [m].

    Raises
    ------
    InputError
        If flanges and web do not make an I.
    """
    clear, middle = height - 2.0 * flange, 0.5 * (height - flange)
    _require(
        min(clear, web, flange, width - web) > 0.0,
        f"two flanges and a web between them, got {height:g} x {width:g} with web {web:g} and flanges {flange:g}",
    )
    return walls(
        Wall(middle, 0.0, flange, width), Wall(0.0, 0.0, clear, web, flange), Wall(-middle, 0.0, flange, width)
    )


def _require(fits: bool, text: str) -> None:
    if not fits:
        raise InputError(f"cross-section: expected {text}; correct its dimensions")
