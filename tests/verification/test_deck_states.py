"""Prestress and masses that decks spread over elements: temperatures, elongations, initial stresses, NSM."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex import MeshError
from verification import decks
from verification.decks import ALUMINIUM, TUBE, beam_frequency, frequencies

EXPANSION, COOLER = 2e-5, 10.0  # [1/K], [K]
FORCE = ALUMINIUM.youngs_modulus * TUBE.area * EXPANSION * COOLER
HOT = decks.PROPERTIES.replace("2700.", "2700.,2.-5,20.")
NO_REFERENCE = HOT.replace(",20.", "")
HINGED = "SPC1,1,1234,1,11\n"


def cooled(control, bulk, properties=HOT):
    """Hinged mast as a deck whose case control selects more than its supports."""
    return decks.nastran(HINGED + bulk, control=f"SPC = 1\n{control}\n", properties=properties)


COOLED = {
    "below TREF": (".bdf", cooled("TEMPERATURE(LOAD) = 5", "TEMPD,5,10.\n")),
    "of points": (
        ".bdf",
        cooled("temp = 5", "TEMPD,5,99.,6,7.\n" + "".join(f"TEMP,5,{k},10.\n" for k in range(1, 12))),
    ),
    "below the initial one": (
        ".bdf",
        cooled("TEMP(LOAD) = 5\nTEMPERATURE(INITIAL) = 6", "TEMPD,5,10.,6,20.\n", NO_REFERENCE),
    ),
    "of beams": (
        ".bdf",
        cooled("TEMP(BOTH) = 5", "TEMPRB,5,1,9.,11.\n,\n,2,THRU,10\n"),
    ),
    "of a preload": (".bdf", cooled("SUBCASE 1\nTEMP = 5\nSUBCASE 2\nMETHOD = 1\nSTATSUB = 1", "TEMPD,5,10.\n")),
    "elongations": (
        ".bdf",
        cooled("DEFORM = 5", "".join(f"DEFORM,5,{k},{-0.1 * EXPANSION * COOLER}\n" for k in range(1, 11))),
    ),
    "of a step": (
        ".inp",
        decks.abaqus(
            "*Beam section, elset=B31, material=hot, section=GENERAL\n1e-4, 8.33e-10, 0., 8.33e-10, 1.4e-9\n0, 1., 0.\n"
            "*Nset, nset=all, generate\n1, 11, 1\n*Initial conditions, type=TEMPERATURE\nall, 20.\n"
            f"*Material, name=hot\n*Elastic\n7e10, 0.33\n*Density\n2700.\n*Expansion, zero=5.\n{EXPANSION}\n",
            "*Boundary\nroot, 1, 4\ntip, 1, 4\n",
            "*Step\n*Static\n*Temperature\nall, 10.\n*End step\n" + decks.STEP,
        ),
    ),
}


@pytest.mark.parametrize("name", COOLED)
def test_cooling_between_held_ends(name, read, verification_row):
    """A hinged mast under the tension E A a T: f = f0 sqrt(1 + N L^2 / (pi^2 E I))."""
    suffix, text = COOLED[name]
    mesh = read(suffix, text)
    model = mesh.model()
    assert model.groups[0].initial == pytest.approx(FORCE)
    stiffness = ALUMINIUM.youngs_modulus * TUBE.inertia_y
    wanted = beam_frequency(np.pi**2) * np.sqrt(1.0 + FORCE / (np.pi**2 * stiffness))
    found = tf.solve_modes(tf.solve_prestress(model), n=1).frequencies[0]
    verification_row(f"deck, temperatures {name}: first frequency [Hz]", wanted, found, "tensioned hinged beam")
    assert found == pytest.approx(wanted, rel=1e-5)
    assert mesh.model(beam_axial_force=0.0).groups[0].initial == pytest.approx(0.0)


def test_cooled_film_is_taut_in_all_directions(read, verification_row):
    """E a T / (1 - nu) in a square of four quadrilaterals; TEMPP1 states one of them, its points the others."""
    mesh = read(
        ".bdf",
        "SOL 101\nCEND\nTEMP = 5\nBEGIN BULK\n"
        + "".join(f"GRID,{1 + i + 3 * j},,{i / 2},{j / 2},0.\n" for j in range(3) for i in range(3))
        + "".join(f"CQUAD4,{k},1,{a},{a + 1},{a + 4},{a + 3}\n" for k, a in enumerate((1, 2, 4, 5), start=1))
        + "PSHELL,1,1,1.-4\nMAT1,1,3.5+9,,.34,1530.,2.-5\nTEMPD,5,-10.\nTEMPP1,5,4,-20.,3.\nENDDATA\n",
    )
    wanted = 3.5e9 * EXPANSION * COOLER / (1.0 - 0.34)
    found = mesh.model().groups[0].initial
    verification_row("deck, cooled film: stress [Pa]", wanted, found[0, 0], "E a T / (1 - nu)")
    assert found == pytest.approx(wanted * np.array([[1, 1, 0]] * 3 + [[2, 2, 0]]))


@pytest.mark.parametrize(
    ("control", "bulk", "properties", "words"),
    [
        ("TEMP = 5", "", HOT, "expected set 5, which TEMPERATURE(LOAD) = 5 selects, got none; add its TEMP"),
        ("DEFORM = 5", "", HOT, "which DEFORM = 5 selects, got none"),
        ("DEFORM = 5", "DEFORM,5,99,1.\n", HOT, "expected rods, bars or beams, got element 99"),
        ("TEMP = 5", "TEMP,5,1,1.\n", HOT, "element 1: expected a temperature of its grid point 2 in set 5"),
        ("TEMP = 5\nTEMP(INIT) = 5", "TEMPD,5,1.\n", HOT, "expected a blank TREF"),
        ("TEMP = 5", "TEMPD,5,1.\nMATT1,1,7\n", HOT, "('MATT1'): expected materials that do not depend"),
        ("TEMP = 5", "TEMPRB,5,1,1.,1.,3.\n", HOT, "got gradients"),
        ("TEMP = 5", "TEMPD,5,1.\n", HOT.replace("MAT1,1", "MAT8,1"), "expected a MAT1 beside temperatures"),
        ("SUBCASE 1\nTEMP = 5\nSUBCASE 2\nTEMP = 6", "", HOT, "choose one with step = number"),
        ("NSM = 5", "NSM1,5,PSHELL,1.,1\n", HOT, "expected elements or properties of PSHELL, got no elements of 1"),
        ("NSM = 5", "NSM1,5,ELEMENT,1.,1,99\n", HOT, "got no elements of 99"),
        ("NSM = 5", "NSM1,5,PFILM,1.,1\n", HOT, "expected a type of PSHELL"),
        ("TEMP = 5", "NSM1,5,PBAR,1.,1\nTEMPD,5,1.\n", HOT, "expected NSM = number for the sets 5 of NSM"),
    ],
)
def test_what_cannot_be_had_of_a_deck(control, bulk, properties, words, read):
    with pytest.raises(MeshError) as caught:
        read(".bdf", cooled(control, bulk, properties))
    assert words in str(caught.value)


def test_what_is_not_selected_costs_nothing(read):
    text = decks.nastran(decks.HELD + "TEMPD,5,10.\nTEMP,5,99,1.\nDEFORM,6,99,1.\nMATT1,1,7\n", properties=HOT)
    assert read(".bdf", text).free_strain == {}


SPREAD = {
    "NSML1": "NSML1,5,ELEMENT,2.5,6,THRU,10\n",
    "NSML": "NSML,5,ELEMENT,6,.5,7,.5,8,.5\nNSML,5,ELEMENT,9,.5,10,.5\n",
    "NSM": "NSM,6,ELEMENT,6,5.,7,5.,8,5.\nNSM,6,ELEMENT,9,5.,10,5.\nNSMADD,5,6\n",
    "NSM1": "NSM1,5,PBAR,5.,2\n",
}


@pytest.mark.parametrize("name", SPREAD)
def test_masses_on_the_outer_half(name, read, verification_row):
    """2.5 kg on the outer half of the mast, 1.907 Hz."""
    bars = "".join(f"CBAR,{k},{1 + (k > 5)},{k},{k + 1},0.,0.,1.\n" for k in range(1, 11))
    both = decks.PROPERTIES + "PBAR,2,1,1.0-4,8.33-10,8.33-10,1.4-9\n"
    mesh = read(
        ".bdf", decks.nastran(decks.HELD + SPREAD[name], control="SPC = 1\nNSM = 5\n", bars=bars, properties=both)
    )
    assert mesh.model().mass == pytest.approx(2.77)
    found = frequencies(mesh)[0]
    verification_row(f"deck, {name} of 2.5 kg on the outer half [Hz]", 1.907, found, "shared/cases a05")
    assert found == pytest.approx(1.907, rel=3e-4)


def film(order, place, stress, extra=""):
    """Square film of one quadrilateral, its corners in some order at some place."""
    points = [place(x, y) for x, y in ((0, 0), (2, 0), (2, 1), (0, 1))]
    nodes = "".join(f"{k}, {x}, {y}, {z}\n" for k, (x, y, z) in enumerate(points, start=1))
    return (
        f"*Node\n{nodes}*Element, type=M3D4, elset=film\n1, {', '.join(map(str, order))}\n"
        f"*Membrane section, elset=film, material=m{extra}\n1e-4\n*Material, name=m\n*Elastic\n3e9, 0.3\n"
        f"*Density\n1500.\n*Initial conditions, type=STRESS\nfilm, {', '.join(map(str, stress))}\n"
    )


def test_sheared_films_in_all_positions(read, verification_row):
    """The format's second axis is the corner order's normal times the first: along x, or z of film across x."""
    slanted = np.array([[2.0, 1.0, 2.0], [-2.0, 2.0, 1.0], [-1.0, -2.0, 2.0]]) / 3.0
    around, back = (1, 2, 3, 4), (1, 4, 3, 2)
    cases = {
        "flat": (around, lambda x, y: (x, y, 0), (3.0, 5.0, 2.0)),
        "flat, listed the other way round": (back, lambda x, y: (x, y, 0), (3.0, 5.0, -2.0)),
        # Axes of the structure are y and z there; those of the format z and -y.
        "across x": (around, lambda x, y: (0, x, y), (5.0, 3.0, -2.0)),
        "across x, listed the other way round": (back, lambda x, y: (0, x, y), (5.0, 3.0, 2.0)),
        "across y, facing -y": (around, lambda x, y: (x, 0, y), (3.0, 5.0, -2.0)),
        "slanted": (around, lambda x, y: tuple(np.array([x, y, 0.0]) @ slanted), None),
    }
    for name, (order, place, wanted) in cases.items():
        mesh = read(".inp", film(order, place, (3.0, 5.0, 2.0)))
        found = mesh.initial_stress["quads"][0]
        if wanted is None:
            # As a tensor in space, of the format's own definition.
            x, z = np.eye(3)[0], slanted[2]
            first = x - (x @ z) * z
            first /= np.linalg.norm(first)
            second = np.cross(z, first)
            tensor = 3.0 * np.outer(first, first) + 5.0 * np.outer(second, second)
            tensor += 2.0 * (np.outer(first, second) + np.outer(second, first))
            across = np.cross(z if z[2] > 0 else -z, first)
            wanted = first @ tensor @ first, across @ tensor @ across, first @ tensor @ across
        assert found == pytest.approx(np.array(wanted), abs=1e-12), name
        assert mesh.model().groups[0].initial[0] == pytest.approx(found)
    verification_row("deck, sheared film: stresses in six positions", "by hand", "the same", "rotation of a tensor")


def test_initial_stress_along_axes_that_are_not_read(read):
    place = lambda x, y: (x, y, 0)  # noqa: E731
    turned = ", orientation=o"
    assert read(".inp", film((1, 2, 3, 4), place, (3.0, 3.0), turned)).initial_stress["quads"][0, 0] == 3.0
    with pytest.raises(MeshError, match="some along an ORIENTATION"):
        read(".inp", film((1, 2, 3, 4), place, (3.0, 5.0), turned))


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ("*Temperature, file=a\n", "got 'FILE'"),
        ("*Temperature\nroot, 1., 2.\n", "gradients"),
        ("*Temperature\nroot, 1.\n*Temperature, op=ALL\nroot, 2.\n", "OP=NEW or OP=MOD"),
    ],
)
def test_temperatures_that_are_not_read(lines, words, read):
    with pytest.raises(MeshError) as caught:
        read(".inp", decks.abaqus(steps=decks.STEP.replace("*Frequency", lines + "*Frequency")))
    assert words in str(caught.value)


def test_expansions_that_are_not_read(read):
    section = "*Beam section, elset=B31, material=hot, section=RECT\n0.01, 0.01\n0., 0., 1.\n"
    hot = "*Material, name=hot\n*Elastic\n7e10, 0.33\n*Expansion, type=ORTHO\n1e-5, 2e-5, 3e-5\n"
    warm = decks.STEP.replace("*Frequency", "*Temperature\nroot, 1.\n*Frequency")
    assert read(".inp", decks.abaqus(section + hot)).free_strain == {}
    with pytest.raises(MeshError, match="expected one number for all directions"):
        read(".inp", decks.abaqus(section + hot, steps=warm))
    with pytest.raises(MeshError, match="expected a MATERIAL beside"):
        read(".inp", decks.abaqus(section, steps=warm))
