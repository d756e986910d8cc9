"""Average stress along a straight way: energies of all laws, and the energy-conserving method [theory.md 8].

The stress is the derivative of the stored energy, so its mean along a straight line of strains does exactly the work
that the energy takes up, whatever the law: ``mean . change of strain = change of energy`` is the fundamental theorem of
calculus. It is symmetric in both ends, becomes the stress where they meet, and its derivative is a mean of tangents,
symmetric and never indefinite where these are not. No energy is subtracted and nothing divided by the change of strain,
so round-off stays that of the stress itself [average vector field: Quispel & McLaren, J. Phys. A 41 (2008) 045206].
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tautflex.elements.laws.law import call_law
from tautflex.mechanics.store import ELASTIC, INTEGRATED
from tautflex.numeric import Array, jit

# Lobatto's rule of four points and Kronrod's extension to seven [Gander & Gautschi, BIT 40 (2000) 84]. Both see the
# ends, so that no bend of the stress hides between the last point and an end.
_PLACES = np.array(
    [0.0, 0.5 - np.sqrt(1 / 6), 0.5 - np.sqrt(0.05), 0.5, 0.5 + np.sqrt(0.05), 0.5 + np.sqrt(1 / 6), 1.0]
)
_FINE = np.array([77.0, 432.0, 625.0, 672.0, 625.0, 432.0, 77.0]) / 2940.0
_COARSE = np.array([1.0, 0.0, 5.0, 0.0, 5.0, 0.0, 1.0]) / 12.0
# Relative to the stresses met: a few times their round-off.
_TOLERANCE = 16.0 * float(np.finfo(float).eps)
# Every other cut halves an interval, and one of a width below the tolerance passes: there are never more ends waiting.
_DEPTH = 128


@jit
def average_stress(
    data: Any, ends: Array, tangent: Array, energy: Array, strain: Array, strain_end: Array, width: int
) -> None:
    """Replace ``ends[:strain]`` by the mean stress of a pack; fill in a nonlinear law's tangents, see `Law.average`.

    ``ends`` (2 strain, pack) holds the trial stresses at the start above those at the end, ``strain`` and
    ``strain_end`` the strains there.
    """
    strains = strain.shape[0]
    if data.law == ELASTIC:
        for s in range(strains):
            row, other = ends[s], ends[strains + s]
            for e in range(width):
                row[e] = 0.5 * (row[e] + other[e])
        return
    if data.average != INTEGRATED:
        call_law(data.average, ends, tangent, energy, data.law_parameters, width)
        return
    move, mean, slope = np.empty(strains), np.empty(strains), np.empty((strains, strains))
    for e in range(width):
        for s in range(strains):
            move[s] = strain_end[s, e] - strain[s, e]
        integrate(data.law, data.law_parameters, ends[:strains, e], ends[strains:, e], move, mean, slope)
        for s in range(strains):
            ends[s, e] = mean[s]
            for t in range(strains):
                tangent[s, t, e] = slope[s, t]


@jit
def integrate(law: int, parameters: Array, start: Array, end: Array, move: Array, mean: Array, slope: Array) -> None:
    """Fill in the mean stress of a law between two trial stresses, shapes (strain,), and twice its derivative.

    Intervals on which the two rules differ are cut in turn where the tangents of their ends meet, which finds the
    bend of a law between two smooth states, and in the middle. ``move`` is the change of strain.
    """
    strains, points = start.size, _PLACES.size
    stress, tangent, energy = np.empty((strains, points)), np.empty((strains, strains, points)), np.empty(points)
    fine, ends = np.empty(strains), np.empty(_DEPTH)
    first, ends[0], waiting, cuts = 0.0, 1.0, 1, 0
    scale = max(np.abs(start).max(), np.abs(end).max())
    mean.fill(0.0)
    slope.fill(0.0)
    while waiting > 0:
        width = ends[waiting - 1] - first
        for p in range(points):
            share = first + width * _PLACES[p]
            for s in range(strains):
                stress[s, p] = (1.0 - share) * start[s] + share * end[s]
        call_law(law, stress, tangent, energy, parameters, points)
        difference = 0.0
        for s in range(strains):
            fine[s], coarse = 0.0, 0.0
            for p in range(points):
                fine[s] += _FINE[p] * stress[s, p]
                coarse += _COARSE[p] * stress[s, p]
            difference = max(difference, abs(fine[s] - coarse))
            scale = max(scale, abs(fine[s]))
        if width * difference > _TOLERANCE * scale and waiting < _DEPTH:
            share = _meeting(stress, tangent, move, width) if cuts % 2 == 0 else 0.5
            ends[waiting] = first + share * width
            waiting += 1
            cuts += 1
            continue
        mean += width * fine
        for p in range(points):
            slope += 2.0 * width * _FINE[p] * (first + width * _PLACES[p]) * tangent[:, :, p]
        first = ends[waiting - 1]
        waiting -= 1


@jit
def _meeting(stress: Array, tangent: Array, move: Array, width: float) -> float:
    """Share of an interval where the tangents of the work at its ends meet; its middle if they do not inside."""
    last = stress.shape[1] - 1
    rise, slope, slope_end = 0.0, 0.0, 0.0
    for s in range(move.size):
        rise += move[s] * (stress[s, last] - stress[s, 0])
        for t in range(move.size):
            slope += move[s] * tangent[s, t, 0] * move[t]
            slope_end += move[s] * tangent[s, t, last] * move[t]
    share = (rise / width - slope_end) / (slope - slope_end)
    return share if 0.0 < share < 1.0 else 0.5
