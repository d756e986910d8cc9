r"""Stress of a film as a page evaluates it: a polynomial of the coordinates, in few fields [theory.md 10].

On ``z``, which has coordinates, monomials, numbers of the command and motion of the frame, the gradients of a film
element are ``g = G z``, and its stress is, to the second degree of the coordinates and the first of what acts,

    s = s0 + c u + D (L G z + eta G' Q G eta / 2),

which is linear in z, and exact for a flat von Karman film. What a page needs of that is a few fields of stress times
the rows that say how much of each there is. Elements that come nearest to compression stand for all where there are
many.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tautflex.control.compiled.compiled_plant import CompiledPlant
from tautflex.mechanics.membrane import principal_values
from tautflex.numeric import Array, Indices
from tautflex.pages.encode import exact, packed, quantised, unpacked
from tautflex.pages.thinning import Drawing
from tautflex.reduction.polynomial.monomials import monomials
from tautflex.reduction.polynomial.monomials import packed as packed_form

# Points of the film that a page watches at most; fields below this part of the strongest one are left out.
_MOST, _WEAK = 640, 1e-3
# Motions that are tried, up to so many times the size of a coordinate; how many of them a page is checked by.
_TRIED, _LARGE, _CHECKED = 64, 1.0, 8


class FilmStress(NamedTuple):
    """Resultants of a film [N/m] at its integration points: ``level + fields @ (mix @ z)``.

    Parameters
    ----------
    level
        At rest, (xx, yy, xy), shape (point, 3).
    fields
        Shape (point, 3, k).
    mix
        Shape (k, z).
    area
        Share of the film's area [-], shape (point,).
    element
        Film element of each point, shape (point,).
    """

    level: Array
    fields: Array
    mix: Array
    area: Array
    element: Indices

    def least(self, z: Array) -> Array:
        """Smaller principal resultant of every point [N/m], shapes (z,) -> (point,)."""
        return principal_values(self.level + self.fields @ (self.mix @ z))[:, 0]


def film_stress(plant: CompiledPlant, sizes: Array) -> FilmStress | None:
    """Stress of a plant's film in the fields that tell it apart at sizes of z, shape (z,); None without a film."""
    system, r, m = plant.rom.state.system, plant.rom.size, plant.rom.monomial_count
    vectors, columns = plant.moved_by()
    extended, parts, before = np.pad(vectors, ((0, 0), (0, 1))), [], 0
    for number in system.block_index("membrane"):
        block, thickness = system.blocks[number], system.blocks[number].size[:, None]
        gradient = np.matmul(block.gradient, extended[:, system.row_places[number]].transpose(1, 2, 0))
        strain, own = np.einsum("sg,egz->esz", block.linear, gradient), gradient[..., :r]
        bent = np.einsum("egi,sgh,ehj->esij", own, block.quadratic, own, optimize=True)
        strain[..., r : r + m] += 0.5 * packed_form(bent)
        stress = block.elasticity @ strain
        if number in columns:
            stress[..., r + m : r + m + columns[number].shape[2]] += columns[number]
        owner = np.arange(len(thickness)) if block.owner is None else block.owner
        level = system.initial_stress[number] * thickness
        parts.append((level, stress * thickness[..., None], block.measure / block.size, before + owner))
        before += int(owner[-1]) + 1
    if not parts:
        return None
    level, whole, area, element = (np.concatenate(each) for each in zip(*parts, strict=True))
    weighed = (whole * sizes).reshape(-1, len(sizes))
    _, values, turn = np.linalg.svd(weighed, full_matrices=False)
    turn = turn[values > _WEAK * values[0]]
    mix = turn / np.where(sizes > 0.0, sizes, np.inf)
    return FilmStress(level, (weighed @ turn.T).reshape(*level.shape, -1), mix, area / area.sum(), element)


def film_data(plant: CompiledPlant, drawing: Drawing, sizes: Array) -> dict[str, Any] | None:
    """What a page knows of the stress of the film, and what it is checked by; None without a film."""
    film = film_stress(plant, sizes)
    if film is None:
        return None
    motions = _motions(plant, sizes)
    nearest = np.min([film.least(z) for z in motions], axis=0)
    some = np.sort(np.argsort(nearest, kind="stable")[:_MOST])
    fields, mix = quantised(film.fields[some]), quantised(film.mix)
    shown = FilmStress(film.level[some], unpacked(fields), unpacked(mix), film.area[some], film.element[some])
    elements, place = np.unique(shown.element, return_inverse=True)
    triangles = plant.rom.state.model.triangle_owner[drawing.triangles]
    drawn = np.full(int(film.element.max()) + 1, len(elements))
    drawn[elements] = np.arange(len(elements))
    chosen = motions[:: _TRIED // _CHECKED]
    return {
        "level": exact(shown.level),
        "fields": fields,
        "mix": mix,
        "area": packed(shown.area),
        # Element of every point, of those that are watched, and of every triangle; one more: of none.
        "element": packed(place),
        "triangle": packed(drawn[triangles]),
        "elements": len(elements),
        "whole": int(film.element.max()) + 1,
        "check": {"z": exact(chosen), "least": exact([shown.least(z).min() for z in chosen])},
    }


def _motions(plant: CompiledPlant, sizes: Array) -> Array:
    """Motions of all kinds and sizes, shape (n, z)."""
    r, m = plant.rom.size, plant.rom.monomial_count
    found = np.random.default_rng(0).normal(size=(_TRIED, len(sizes))) * sizes
    found[:, :r] *= np.linspace(0.1, _LARGE, _TRIED)[:, None]
    found[:, r : r + m] = monomials(found[:, :r])
    return found
