"""The film as a reflecting surface: planes, half-waves, Ruze's loss, and reduced models against the full film."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex.mechanics.surface import FilmSurface, SurfaceOnVectors
from tautflex.solvers.variables import OF_SURFACE
from tautflex.structure.antenna import AntennaLayout, build_fixed_film
from verification.builders import FILM, antenna
from verification.dynamic_cases import small_antenna

SHAPES = ("triangle3", "triangle6", "quad4")
A, B = 2.0, 1.0


def measured(model, displacement):
    """rms, tilts and piston of a displacement of all nodes, shape (node, 3)."""
    full, found = np.zeros(model.dof_count), np.empty(4)
    full[model.translation_dofs] = displacement
    FilmSurface(model).measure(full[model.free_dofs], found)
    return found


def film(element, divisions, **given):
    section = tf.MembraneSection(FILM, 1e-4)
    return build_fixed_film(AntennaLayout(A, B, divisions, element=element, **given), section, (4e3, 4e3, 0.0))


def loose(model, turn=None, shift=(0.0, 0.0, 0.0)):
    """The film alone, turned, moved away and free."""
    group = model.surfaces[0]
    used, places = np.unique(group.connectivity, return_inverse=True)
    return tf.Model.from_mesh(
        model.nodes[used] @ (np.eye(3) if turn is None else turn.T) + shift,
        surfaces={group.shape.name: places.reshape(group.connectivity.shape)},
        membrane=group.section,
        membrane_stress=(4e3, 4e3, 0.0),
    )


@pytest.mark.parametrize("element", SHAPES)
def test_plane_has_tilt_and_piston_and_no_rms(element, verification_row):
    """w = a + b x + c y turns the surface by c about x and by -b about y [theory.md 7]."""
    model = loose(film(element, (5, 4)))
    x, y, _ = model.nodes.T
    plane = np.stack([0.0 * x, 0.0 * x, 1e-3 + 2e-3 * x - 3e-3 * y], axis=1)
    found = measured(model, plane)
    np.testing.assert_allclose(found, [0.0, -3e-3, -2e-3, 1e-3], atol=1e-17)
    rotated = measured(model, np.cross([4e-4, 5e-4, 6e-4], model.nodes))
    np.testing.assert_allclose(rotated, [0.0, 4e-4, 5e-4, 0.0], atol=1e-17)
    verification_row(f"{element}: rms of a film that moves as a plane, of 1 mm", 0.0, found[0], "the plane itself")


def test_axes_of_a_film_that_stands_anywhere():
    """A film turned in space and moved away: its own displacement across it, rotations about its own axes."""
    turn = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    model = loose(film("triangle6", (3, 2)), turn, (5.0, -2.0, 1.0))
    normal = turn[:, 2] * np.sign(turn[np.abs(turn[:, 2]).argmax(), 2])
    along = np.eye(3)[int(abs(normal[0]) > np.sqrt(0.5))]
    first = along - (along @ normal) * normal
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    centre = np.array([5.0, -2.0, 1.0])
    moved = np.cross(3e-4 * first - 2e-4 * second, model.nodes - centre) + 1e-3 * normal + 0.5 * first
    np.testing.assert_allclose(measured(model, moved), [0.0, 3e-4, -2e-4, 1e-3], atol=1e-14)


@pytest.mark.parametrize(("element", "order"), [("triangle3", 2), ("triangle6", 4), ("quad4", 2)])
def test_half_wave_on_fixed_edges(element, order, verification_row):
    """w = W cos(pi x/a) cos(pi y/b): mean 4 W/pi^2, no tilt, rms^2 = W^2 (1/4 - 16/pi^4)."""
    expected, wrong = 1e-3 * np.sqrt(0.25 - 16.0 / np.pi**4), []
    for cells in (8, 16):
        model = film(element, (2 * cells, cells))
        x, y, _ = model.nodes.T
        wave = np.stack([0.0 * x, 0.0 * x, 1e-3 * np.cos(np.pi * x / A) * np.cos(np.pi * y / B)], axis=1)
        rms, tilt_x, tilt_y, piston = measured(model, wave)
        wrong.append([abs(rms / expected - 1.0), abs(piston * np.pi**2 / 4e-3 - 1.0)])
        assert np.abs([tilt_x, tilt_y]).max() < 1e-17 + 2e-2 * (wrong[-1][1] * piston)
    np.testing.assert_allclose(np.log2(np.divide(*wrong)), order, atol=0.15)
    assert np.max(wrong[-1]) < 0.011
    verification_row(f"{element}, 32 x 16 cells: rms of one half-wave, mm", 1e3 * expected, 1e3 * rms, "closed form")


def test_ruze_loss(verification_row):
    """G = G0 - 685.81 (rms/wavelength)^2 dB [Ruze's equation as tabled]."""
    frequency, rms = 10e9, np.array([0.0, 299792458.0 / 10e9 / 16.0, 1e-3])
    loss = tf.ruze_loss(rms, frequency)
    np.testing.assert_allclose(loss, 685.81 * (rms * frequency / 299792458.0) ** 2, rtol=1e-5)
    assert loss.attrs["units"] == "dB"
    verification_row("Ruze's loss at a sixteenth of the wavelength [dB]", 685.81 / 256.0, float(loss[1]), "Ruze 1966")
    for wrong in ({"frequency": 0.0}, {"rms": -1e-3}, {"rms": "a"}):
        with pytest.raises(tf.InputError, match=f"{next(iter(wrong))}: expected"):
            tf.ruze_loss(**{"rms": 1e-3, "frequency": frequency} | wrong)


def test_settling_time(verification_row):
    """A decaying vibration leaves a tolerance for the last time where its envelope says, to within half a period."""
    step, decay, omega = 1e-3, 0.8, 2.0 * np.pi * 3.0
    time = step * np.arange(6001)
    envelope = (np.exp(-decay * time), step)
    exact = np.log(50.0) / decay
    assert tf.settling_time(envelope, 0.02) == pytest.approx(exact, abs=1e-6)
    assert tf.settling_time(envelope, 0.02, after=1.0) == pytest.approx(exact - 1.0, abs=1e-6)
    vibration = (np.exp(-decay * time) * np.cos(omega * time), step)
    assert exact - np.pi / omega < tf.settling_time(vibration, 0.02) < exact
    assert tf.settling_time(envelope, 1.0) == 0.0
    assert np.isnan(tf.settling_time(envelope, 1e-4))
    with pytest.raises(tf.InputError, match="tolerance: expected"):
        tf.settling_time(envelope, 0.0)
    verification_row("exp(-0.8 t): settling time to 2 % [s]", exact, tf.settling_time(envelope, 0.02), "ln 50 / 0.8")


STEPS = {"time_step": 2e-3, "end_time": 0.1, "probes": {"A": (0.6, 0.3)}, "fields": "all", "method": tf.Newmark()}


def of_fields(state, data):
    """The measures of the stored fields."""
    return np.array([measured(state.model, field) for field in data["displacement"].values]).T


@pytest.mark.parametrize("plant", ["full", "hub", "reduced", pytest.param("hyper", marks=pytest.mark.slow)])
def test_every_plant_records_what_its_fields_show(plant, verification_row):
    """A run's record, from forms that were projected once, is that of its whole displacement field."""
    state = tf.solve_prestress(small_antenna())
    maneuver = tf.Stop(0.6, 0.04)
    rom = state
    if plant == "reduced":
        rom = tf.reduce(state, tf.ModalBasis(directions=("z", "rx", "ry"), count=6))
    if plant == "hub":
        maneuver = tf.FreeHub(mass=50.0, inertia=(5.0, 5.0, 8.0), angular_velocity=(0.1, 0.0, 0.0))
    if plant == "hyper":
        rom = tf.hyper_reduce(state, [tf.simulate(state, maneuver, **STEPS)])
    data = tf.simulate(rom, maneuver, **STEPS).data
    expected, found = of_fields(state, data), np.array([data[name].values for name in OF_SURFACE])
    rms, tilt = expected[0].max(), np.abs(expected[1:3]).max()
    wrong = float(np.max(np.abs(found - expected) / np.array([[rms], [tilt], [tilt], [rms]])))
    # Round-off; what follows a reduced model's coordinates in the film's plane is round-off across it, and left out.
    assert wrong < (1e-9 if plant == "reduced" else 1e-12)
    measures = tf.surface(data)
    np.testing.assert_array_equal(measures["rms"], data["surface_rms"])
    assert measures["tilt_x"].attrs["units"] == "rad"
    verification_row(f"surface measures of a run ({plant}) beside those of its fields", 0.0, wrong, "the same forms")


def test_forms_on_vectors_are_those_of_their_sum():
    """Twelve vectors that move everything, small parts beside a large tilt."""
    model, chance = small_antenna(), np.random.default_rng(5)
    film, size = FilmSurface(model), len(model.free_dofs)
    vectors, amounts = chance.standard_normal((12, size)), chance.standard_normal((20, 12))
    vectors[0] = 1e6 * (film.look.T @ film.plane[:, 1])
    expected = np.empty((20, 4))
    for row, some in zip(expected, amounts, strict=True):
        film.measure(some @ vectors, row)
    scale = np.abs(expected).max(axis=0)
    np.testing.assert_allclose(SurfaceOnVectors(film, vectors).measure(amounts) / scale, expected / scale, atol=1e-9)
    vectors[0] *= 1e-6
    for row, some in zip(expected, amounts, strict=True):
        film.measure(some @ vectors, row)
    np.testing.assert_allclose(SurfaceOnVectors(film, vectors).measure(amounts), expected, rtol=1e-11, atol=1e-13)


def test_structures_without_film_say_so():
    model = antenna((0.59, 1.0), (2, 2))
    cables = tf.Model.from_mesh(
        [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [1.0, 0.0, 0.0]],
        cables=[[0, 1], [1, 2]],
        cable=model.groups[1].section,
        cable_tension=1.0,
        supports=(tf.Support.pinned([0, 2]),),
    )
    run = tf.simulate(tf.solve_prestress(cables), time_step=1e-3, end_time=5e-3)
    with pytest.raises(tf.InputError, match="run: expected one of a structure with film"):
        tf.surface(run)
