"""Statics where film and cables are about to give way: bent and torqued membranes, cables that hang from slack."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import tautflex as tf
from tautflex.mechanics.membrane import survey_at
from tautflex.structure.mesh import rectangle_mesh
from tautflex.structure.shapes import TRIANGLE6
from verification.builders import FILM, THICKNESS, line_elements, observed_order, unstressed

Array = NDArray[np.float64]

YOUNG, POISSON, STRESS = FILM.youngs_modulus, FILM.poisson_ratio, 1e6


def edge_load(nodes: Array, edge: Array, along: int, traction, kink: float = 0.0) -> Array:
    """Consistent forces [N] of a traction [N/m] on the nodes of the sides of six-node triangles along an edge."""
    points, weights = np.polynomial.legendre.leggauss(4)
    force = np.zeros(len(nodes))
    edge = edge[np.argsort(nodes[edge, along])]
    for side in (edge[i : i + 3] for i in range(0, len(edge) - 2, 2)):
        begin, end = nodes[side[[0, 2]], along]
        cuts = sorted({begin, end, min(max(kink, begin), end)})
        for low, high in pairwise(cuts):
            place = 0.5 * (low + high + (high - low) * points)
            s = (place - begin) / (end - begin)
            functions = np.array([(1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)])
            force[side] += functions @ (0.5 * (high - low) * weights * traction(place))
    return force


@pytest.mark.slow
@pytest.mark.parametrize("across", [1.0, 0.0], ids=["stretched both ways", "stretched one way"])
@pytest.mark.parametrize("moment", [0.2, 0.3, 0.4])
def test_bending_of_a_stretched_strip(moment, across, verification_row):
    """Strip of height H under P and M in its plane: for M/PH > 1/6 a band of 3 M/PH - 1/2 of H pulls no more.

    Beyond the band the stress rises on a line. Stretched one way only, all of the film is at the border between taut
    and wrinkled, and the band is slack; the strip starts without any stress.
    """
    nodes, elements = rectangle_mesh(np.linspace(0.0, 0.5, 11), np.linspace(0.0, 1.0, 21), shape=TRIANGLE6)
    x, y, _ = nodes.T
    band = 3.0 * moment - 0.5

    def pull(place):
        return STRESS * THICKNESS * 2.0 * np.maximum(place - band, 0.0) / (1.0 - band) ** 2

    forces = np.zeros_like(nodes)
    for column, along, sign, edge in (
        (0, 1, 1.0, x > 0.5 - 1e-9),
        (0, 1, -1.0, x < 1e-9),
        (1, 0, across, y > 1.0 - 1e-9),
        (1, 0, -across, y < 1e-9),
    ):
        traction = pull if column == 0 else lambda place: np.full_like(place, STRESS * THICKNESS)
        forces[:, column] += sign * edge_load(nodes, np.flatnonzero(edge), along, traction, band if along else 0.0)
    corner = [int(np.argmin(np.hypot(x - place, y - 1.0))) for place in (0.0, 0.5)]
    supports = (tf.Support((corner[0],), ("x", "y")), tf.Support((corner[1],), ("y",)))
    model = tf.Model.from_mesh(
        nodes,
        triangles=elements,
        membrane=tf.MembraneSection(FILM, THICKNESS, law="tension-field"),
        supports=(*supports, tf.Support(tuple(range(len(nodes))), ("z",))),
    )
    state = unstressed(model)
    q = tf.solve_static(state, forces=forces)
    stress = state.system.stress(q)[0][:, 0] / STRESS
    points, _ = TRIANGLE6.strain_rule
    places = np.einsum("pi,nik->npk", TRIANGLE6.functions(points), nodes[elements]).reshape(-1, 3)
    loaded = stress > 0.1
    slope, offset = np.polyfit(places[loaded, 1], stress[loaded], 1)
    share = -offset / slope
    assert share == pytest.approx(band, rel=0.02)
    assert slope == pytest.approx(2.0 / (1.0 - band) ** 2, rel=0.02)
    assert np.abs(stress[places[:, 1] < band - 0.05]).max(initial=0.0) < 1e-3
    case = f"strip in bending, M/PH = {moment}, stretched {'both ways' if across else 'one way'}"
    verification_row(f"{case}: wrinkled share b/H", band, share, "Stein & Hedgepeth, NASA TN D-813")
    if across:
        found = survey_at(state.system, q).membrane().wrinkled
        assert found == pytest.approx(band, rel=0.02)
        verification_row(f"{case}: wrinkled part of the area", band, found, "Stein & Hedgepeth, NASA TN D-813")


INNER, OUTER = 0.2, 0.5


def reissner(torque: float) -> tuple[float, float]:
    """Turn of the inner edge and radius to which wrinkles reach, for a shear stress there of ``torque * STRESS``.

    Equilibrium: (r s_r)' = s_t, shear tau = C / r^2. Taut, s_t = E u/r + nu s_r; where that leaves s_r s_t < tau^2 the
    relaxed energy has s_t = tau^2 / s_r, tension S = s_r + s_t along cos^2 = s_r / S, strain S/E along it, and across
    it what u / r asks for [Reissner 1938].
    """
    twist = torque * STRESS * INNER**2

    def slopes(r, y):
        u, radial, shear = y[0], y[1] / r, twist / r**2
        hoop = YOUNG * u / r + POISSON * radial
        if radial * hoop >= shear**2:
            return (radial - POISSON * hoop) / YOUNG, hoop, 2.0 * (1.0 + POISSON) * shear / (YOUNG * r)
        hoop = shear**2 / radial
        along, cos2 = (radial + hoop) / YOUNG, radial / (radial + hoop)
        across = (u / r - along * (1.0 - cos2)) / cos2
        turn = 2.0 * (along - across) * np.sqrt(cos2 * (1.0 - cos2))
        return along * cos2 + across * (1.0 - cos2), hoop, turn / r

    def run(u):
        start = u, INNER * STRESS, 0.0
        return solve_ivp(slopes, (INNER, OUTER), start, rtol=1e-9, atol=1e-15, max_step=1e-3, dense_output=True)

    strain = STRESS * (1.0 - POISSON) / YOUNG
    found = run(brentq(lambda u: run(u).y[0, -1] - strain * OUTER, -20 * strain, 20 * strain, xtol=1e-15))
    r = np.linspace(INNER, OUTER, 3001)
    u, pull, _ = found.sol(r)
    taut = pull / r * (YOUNG * u / r + POISSON * pull / r) >= (twist / r**2) ** 2
    return float(found.y[2, -1]), float(r[~taut].max(initial=INNER))


@pytest.mark.parametrize("torque", [0.5, 1.2, 2.0])
def test_torqued_annulus(torque, verification_row):
    """Annular membrane, stretched alike all around, its inner edge turned by shear, the outer one held."""
    rings, count = 32, 128
    radius, angle = np.geomspace(INNER, OUTER, rings + 1), 2.0 * np.pi * np.arange(count) / count
    circle = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)])
    nodes = (radius[:, None, None] * circle).reshape(-1, 3)
    ring, step = np.arange(rings)[:, None] * count, np.arange(count)
    near, far = ring + step, ring + (step + 1) % count
    model = tf.Model.from_mesh(
        nodes,
        quads=np.stack([near, near + count, far + count, far], axis=2).reshape(-1, 4),
        membrane=tf.MembraneSection(FILM, THICKNESS, law="tension-field"),
        membrane_stress=(STRESS, STRESS, 0.0),
        supports=(
            tf.Support.pinned(range(rings * count, len(nodes))),
            tf.Support(tuple(range(len(nodes))), ("z",)),
        ),
    )
    state = tf.solve_prestress(model)
    around = np.cross([0.0, 0.0, 1.0], circle)
    forces = np.zeros_like(nodes)
    forces[:count] = torque * STRESS * THICKNESS * 2.0 * np.pi * INNER / count * around
    q = tf.solve_static(state, forces=forces)
    turn = float(np.mean(np.sum(state.system.translations(q)[:count] * around, axis=1))) / INNER
    reach = np.sqrt(INNER**2 + survey_at(state.system, q).membrane().wrinkled * (OUTER**2 - INNER**2))
    exact, border = reissner(torque)
    assert turn == pytest.approx(exact, rel=5e-3)
    assert reach == pytest.approx(border, rel=0.015)
    verification_row(f"torqued annulus, shear {torque} x stress: turn", exact, turn, "Reissner 1938, relaxed energy")
    verification_row(f"torqued annulus, shear {torque} x stress: wrinkles reach [m]", border, reach, "Reissner 1938")


SPAN, LENGTH, WEIGHT, STIFFNESS = 10.0, 12.0, 1.0, 4e5  # m, m, N/m, N


def catenary_sag() -> float:
    """Sag of an elastic catenary: H from span = 2 H/w asinh(w L / 2H) + H L / EA; depth of rope plus its stretch."""
    half = 0.5 * WEIGHT * LENGTH
    pull = brentq(lambda h: 2 * h / WEIGHT * np.arcsinh(half / h) + h * LENGTH / STIFFNESS - SPAN, 0.1, 100.0)
    return (np.hypot(pull, half) - pull) / WEIGHT + WEIGHT * LENGTH**2 / (8.0 * STIFFNESS)


@pytest.mark.parametrize("slack", [False, True], ids=["elastic", "slack law"])
def test_elastic_catenary_from_a_slack_v(slack, verification_row):
    """Nothing is tense at first, and stretching is 4e5 times stiffer than the weight."""
    exact, found, counts = catenary_sag(), [], (10, 20, 40, 80)
    assert exact == pytest.approx(2.923580, abs=1e-6)
    for count in counts:
        x = np.linspace(0.0, SPAN, count + 1)
        depth = np.sqrt((0.5 * LENGTH) ** 2 - (0.5 * SPAN) ** 2)
        nodes = np.column_stack([x, np.zeros(count + 1), -depth * (1.0 - np.abs(2.0 * x / SPAN - 1.0))])
        section = tf.CableSection(tf.Material(STIFFNESS / 1e-4, 1000.0), 1e-4, "green-lagrange", slack=slack)
        ends = (tf.Support.pinned([0, count]),)
        state = unstressed(tf.Model.from_mesh(nodes, cables=line_elements(count), cable=section, supports=ends))
        forces = np.zeros_like(nodes)
        forces[:, 2] = -WEIGHT * LENGTH / count
        q = tf.solve_static(state, forces=forces)
        found.append(-float((nodes + state.system.translations(q))[:, 2].min()))
        assert state.system.stress(q)[0].min() > 0.0
    order = observed_order(np.array(found) - exact)
    np.testing.assert_allclose(order, 2.0, atol=0.05)
    assert found[-1] == pytest.approx(exact, rel=1e-4)
    law = "slack cables" if slack else "elastic cables"
    for count, sag in zip(counts, found, strict=True):
        verification_row(f"catenary from a slack V, {law}, {count} elements: sag [m]", exact, sag, "elastic catenary")
    verification_row(f"catenary from a slack V, {law}: observed order", 2, float(order[-1]), "straight elements")


def test_a_stiff_rope_that_balances_to_round_off_is_accepted():
    """Stretching 2e7 times stiffer than the weight: element forces carry a round-off far above 1e-9 of the load."""
    count = 40
    x = np.linspace(0.0, SPAN, count + 1)
    nodes = np.column_stack([x, np.zeros(count + 1), -3.0 * (1.0 - np.abs(2.0 * x / SPAN - 1.0))])
    section = tf.CableSection(tf.Material(2e11, 7850.0), 1e-4, "green-lagrange", slack=True)
    ends = (tf.Support.pinned([0, count]),)
    state = unstressed(tf.Model.from_mesh(nodes, cables=line_elements(count), cable=section, supports=ends))
    forces = np.zeros_like(nodes)
    forces[:, 2] = -WEIGHT * LENGTH / count
    q = tf.solve_static(state, forces=forces)
    left = state.system.force(q)[0].reshape(-1, 3) - forces[1:-1]
    assert np.abs(left).max() < 1e-5 * np.abs(forces).max()


def test_what_cannot_stand_says_so():
    """A rope held at one end; the load is not said to be too large where the structure is at fault."""
    loose = tf.Model.from_mesh(
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
        cables=[[0, 1], [1, 2]],
        cable=tf.CableSection(tf.Material(1e9, 1000.0), 1e-6),
        supports=[tf.Support.pinned([0])],
    )
    with pytest.raises(tf.NotConvergedError, match=r"supports and tension do not hold drifts on; check them") as caught:
        tf.solve_static(unstressed(loose), forces=[[0, 0, 0], [0, 0, 1.0], [0, 0, 0]])
    assert caught.value.result.shape == (6,)
    assert "reduce the load" not in str(caught.value)
