"""Sections of mesh files: of every property its own, completed and replaced by groups; against closed forms."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import tautflex as tf
from tautflex import InputError
from tautflex.cli import main
from tautflex.files.mesh.section.profiles import box, double_tee, rectangle, tube
from verification import decks
from verification.builders import antenna
from verification.decks import CLAMPED_FREE, beam_frequency

TUBE = decks.PROPERTIES
OUTER = "".join(f"CBAR,{k},{1 + (k > 5)},{k},{k + 1},0.,0.,1.\n" for k in range(1, 11))
HEAVY = 1.907  # [Hz], mast with 2.5 kg along its outer half
# The same outer half: heavier material, or nonstructural mass of 5 kg/m.
OUTER_HALVES = {
    "density": "PBAR,2,2,1.0-4,8.33-10,8.33-10,1.4-9\nMAT1,2,7.+10,,.33,52700.\n",
    "nonstructural mass": "PBAR,2,1,1.0-4,8.33-10,8.33-10,1.4-9,5.\n",
    "PBEAM": "PBEAM,2,1,1.0-4,8.33-10,8.33-10,,1.4-9,5.\n",
}


def deck(properties, **given):
    """Mast with other properties."""
    return decks.nastran(properties=properties, **given)


def first(model):
    return tf.solve_modes(tf.solve_prestress(model), n=1).frequencies[0]


@pytest.fixture
def read(tmp_path):
    def from_text(suffix, text, **options):
        (tmp_path / f"mesh{suffix}").write_text(text, encoding="utf-8")
        return tf.read_mesh(tmp_path / f"mesh{suffix}", **options)

    return from_text


def test_a_deck_brings_its_section(read, verification_row):
    """SPC 1 of the case control and PBAR: 8.2236 Hz without a section of the user's."""
    mesh = read(".bdf", deck(TUBE))
    found, wanted = first(mesh.model()), beam_frequency(CLAMPED_FREE)
    verification_row("deck, PBAR and MAT1: first frequency [Hz]", wanted, found, "Euler-Bernoulli beam")
    assert found == pytest.approx(wanted, rel=2e-5)
    assert mesh.model().mass == pytest.approx(0.27)


@pytest.mark.parametrize("name", OUTER_HALVES)
def test_two_properties_in_one_mast(name, read, verification_row):
    mesh = read(".bdf", deck(TUBE + OUTER_HALVES[name], bars=OUTER))
    found = first(mesh.model())
    verification_row(f"deck, two properties ({name}): first frequency [Hz]", HEAVY, found, "shared/cases a05")
    assert found == pytest.approx(HEAVY, abs=5e-4)
    assert mesh.model().mass == pytest.approx(2.77)


def test_elements_of_one_section_stand_in_a_row_and_groups_follow(read):
    """Bars of two properties in turn: connectivity, groups and prestress by group agree."""
    bars = "".join(f"CBAR,{k},{1 + k % 2},{k},{k + 1},0.,0.,1.\n" for k in range(1, 11))
    mesh = read(".bdf", deck(TUBE + OUTER_HALVES["density"], bars=bars))
    model = mesh.model(beam_axial_force=mesh.values("beams", {"pid1": 1.0, "pid2": 2.0}))
    assert [len(group.connectivity) for group in model.groups] == [5, 5]
    for group, number in zip(model.groups, (1, 2), strict=True):
        assert {int(a) % 2 for a, _ in group.connectivity} == {2 - number}
        np.testing.assert_array_equal(group.initial, float(number))
    np.testing.assert_array_equal(model.beams, mesh.beams)


def test_groups_replace_and_complete_what_the_file_states(read):
    mesh = read(".bdf", deck(TUBE, bars=OUTER))
    with pytest.raises(InputError, match=r"beam\.youngs_modulus: missing, neither the file nor you state it"):
        mesh.model()
    whole = {"youngs_modulus": 7e10, "poisson_ratio": 0.33, "area": 1e-4, "density": 52700.0}
    whole |= {"inertia_y": 8.33e-10, "inertia_z": 8.33e-10, "torsion_constant": 1.4e-9}
    assert first(mesh.model(sections={"pid2": whole})) == pytest.approx(HEAVY, abs=5e-4)
    with pytest.raises(InputError, match=r"sections: expected groups of elements \('pid1', 'pid2'\), got 'pid3'"):
        mesh.model(sections={"pid3": whole})
    with pytest.raises(InputError, match=r"sections\.pid2\.thickness: expected keys out of"):
        mesh.model(sections={"pid2": whole | {"thickness": 1.0}})


CASE = """schema = 1
[membrane]
edges = "fixed"
[mesh]
file = "mast.bdf"
"""


def test_cases_take_sections_from_decks(tmp_path, capsys):
    """Everything from the deck; a key of a group; a key of the kind, which yields where the file's sections differ."""
    (tmp_path / "mast.bdf").write_text(deck(TUBE + OUTER_HALVES["density"], bars=OUTER))
    (tmp_path / "case.toml").write_text(CASE)

    def frequency(*overrides):
        settings = [part for one in overrides for part in ("--set", one)]
        assert main(["modes", str(tmp_path / "case.toml"), "-n", "1", "--json", *settings]) == 0
        return json.loads(capsys.readouterr().out)["frequencies"][0]

    assert frequency() == pytest.approx(HEAVY, abs=5e-4)
    assert frequency("mesh.sections.pid2.density=2700.0") == pytest.approx(beam_frequency(CLAMPED_FREE), rel=2e-5)
    assert frequency("frame.youngs_modulus=28e10") == pytest.approx(2 * HEAVY, abs=1e-3)  # both have 7e10
    assert frequency("frame.density=2700.0") == pytest.approx(HEAVY, abs=5e-4)
    assert main(["check", str(tmp_path / "case.toml"), "--json", "--set", "frame.density=2700.0"]) == 0
    notes = json.loads(capsys.readouterr().out)["notes"]
    assert any("frame.density = 2700.0 does not hold for all: some have 52700.0" in note for note in notes)


FILM_BDF = (
    "BEGIN BULK\n"
    + "".join(f"GRID,{1 + i + 5 * j},,{i / 4},{j / 4},0.\n" for j in range(5) for i in range(5))
    + "".join(
        f"CQUAD4,{1 + i + 4 * j},{1 + (i > 1)},{a},{a + 1},{a + 6},{a + 5}\n"
        for j in range(4)
        for i in range(4)
        for a in [1 + i + 5 * j]
    )
    + "PSHELL,1,1,1.-4\nPSHELL,2,1,2.-4,,,,,.05\nMAT1,1,3.5+9,,.34,1530.\n"
    "SPC1,1,123,1,2,3,4,5,6\n,10,11,15,16,20,21,22,23\n,24,25\n"
)


def test_film_of_two_thicknesses(read):
    mesh = read(".bdf", FILM_BDF + "ENDDATA\n")
    model = mesh.model(membrane={"strain": "green-lagrange"}, membrane_stress=(1e6, 1e6, 0.0))
    assert model.mass == pytest.approx(0.5 * 1530.0 * 1e-4 + 0.5 * (1530.0 * 2e-4 + 0.05))
    assert [group.section.thickness for group in model.groups] == [1e-4, 2e-4]
    assert {group.section.strain for group in model.groups} == {"green-lagrange"}
    state = tf.solve_prestress(model)
    np.testing.assert_allclose(state.membrane_stress[:, :2], 1e6)


UNITS = deck(
    "PBAR,1,1,1.0+2,8.33+2,8.33+2,1.4+3\nMAT1,1,7.+4,,.33,2.7-9\n",
    grids="".join(f"GRID,{k + 1},,{100.0 * k},0.0,0.0\n" for k in range(11)),
)


def test_units_of_decks(read):
    """Millimetres and tonnes; without the unit of mass modulus and density stay open, and are asked for."""
    mesh = read(".bdf", UNITS, unit_length=1e-3, unit_mass=1e3)
    assert first(mesh.model()) == pytest.approx(beam_frequency(CLAMPED_FREE), rel=2e-5)
    again = read(".bdf", UNITS, unit_length=1e-3)
    with pytest.raises(InputError, match=r"sections\.pid1\.youngs_modulus: missing, .* give unit_mass"):
        again.model()
    model = again.model(sections={"pid1": {"youngs_modulus": 7e10, "density": 2700.0}})
    assert first(model) == pytest.approx(beam_frequency(CLAMPED_FREE), rel=2e-5)


DOUBTS = {
    "laminate": ("PCOMP,1\n", "PCOMP is a laminate"),
    "orthotropic": ("PBAR,1,1,1.0-4,8.33-10,8.33-10,1.4-9\nMAT8,1,7.+10\n", "MAT8, expected the isotropic MAT1"),
    "material": ("PBAR,1,1,1.0-4,8.33-10,8.33-10,1.4-9\n", "material 1 is not there"),
    "I12": (TUBE.replace("1.4-9\n", "1.4-9\n,,,,,,,,\n,,,1.-10\n"), "field 24 = '1.-10' is not read here"),
    "taper": ("PBEAM,1,1,1.0-4,8.33-10,8.33-10,,1.4-9\n,,,,,,,,\n,NO,1.,2.0-4\n", "it tapers"),
    "profile": ("PBARL,1,1,,L\n,1.,2.,3.,4.\n", "cross-section is 'L'"),
    "walls": ("PBARL,1,1,,TUBE\n,1.,2.\n", "expected a radius > 0 and a wall"),
}


@pytest.mark.parametrize("name", DOUBTS)
def test_what_a_section_cannot_say_is_asked_for(name, read):
    """Reading succeeds, so that a user can state the section; using the file's is refused by name."""
    lines, words = DOUBTS[name]
    kept = "" if "MAT" in lines or name == "material" else "MAT1,1,7.+10,,.33,2700.\n"
    mesh = read(".bdf", deck(lines + kept))
    assert first(mesh.model(beam=decks.TUBE)) == pytest.approx(beam_frequency(CLAMPED_FREE), rel=2e-5)
    if name != "laminate":  # of beams it is none
        with pytest.raises(InputError) as caught:
            mesh.model()
        assert words in str(caught.value)


ABAQUS = {
    "RECT": "*Beam section, elset=B31, material=al, section=RECT\n.01, .01\n0., 1., 0.\n",
    "GENERAL": "*Beam general section, elset=B31, section=GENERAL, material=al\n"
    "1e-4, 8.3333e-10, 0., 8.3333e-10, 1.4e-9\n0., 1., 0.\n",
}


@pytest.mark.parametrize("name", ABAQUS)
def test_sections_of_abaqus(name, read):
    mesh = read(".inp", decks.abaqus(ABAQUS[name]))
    assert mesh.sections["B31"].values["inertia_y"] == pytest.approx(1e-8 / 12.0, rel=1e-4)
    assert first(mesh.model()) == pytest.approx(beam_frequency(CLAMPED_FREE), rel=5e-4)
    thick = read(".inp", decks.abaqus("*Beam section, elset=B31, material=al, section=RECT\n.02, .01\n0., 1., 0.\n"))
    moments = [thick.sections["B31"].values[key] for key in ("inertia_y", "inertia_z")]
    np.testing.assert_allclose(moments, [0.02 * 1e-6 / 12.0, 0.01 * 8e-6 / 12.0])  # n1 is local y


def test_films_and_cables_of_abaqus(read):
    text = (
        "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,2,0,0\n*ELEMENT,TYPE=M3D4,ELSET=skin\n1,1,2,3,4\n"
        "*ELEMENT,TYPE=T3D2,ELSET=rope\n2,2,5\n*MATERIAL,NAME=pi\n*ELASTIC\n3e9,.3\n*DENSITY\n1400.\n"
        "*MEMBRANE SECTION,ELSET=skin,MATERIAL=PI\n5e-5\n*SOLID SECTION,ELSET=rope,MATERIAL=pi\n1e-6\n"
        "*BOUNDARY\n1,1,3\n"
    )
    model = read(".inp", text).model(membrane_stress=(1e5, 1e5, 0.0), cable_tension=1.0)
    assert model.mass == pytest.approx(1400.0 * (5e-5 + 1e-6))


def test_profiles(verification_row):
    """Torsion of a square 0.140577 a^4, of a strip b t^3 / 3, of a thin tube 2 pi r^3 t, twice by Bredt."""
    square = rectangle(2.0, 2.0)
    verification_row("torsion constant of a square [a^4]", 0.1405770, square.torsion_constant / 16.0, "Saint-Venant")
    assert square.torsion_constant == pytest.approx(0.1405770 * 16.0, rel=1e-6)
    assert rectangle(1.0, 1e-3).torsion_constant == pytest.approx(1e-9 / 3.0, rel=1e-3)
    assert rectangle(0.3, 0.1).inertia_z == pytest.approx(0.1 * 0.3**3 / 12.0)
    ring = tube(1.0, 1e-4)
    assert ring.torsion_constant == pytest.approx(2.0 * np.pi * 1e-4, rel=1e-3)
    assert tube(1.0).area == pytest.approx(np.pi)
    hollow = box(2.0, 2.0, 1e-4, 1e-4)
    assert hollow.torsion_constant == pytest.approx(2.0**3 * 1e-4, rel=1e-3)  # a^3 t
    beam = double_tee(0.2, 0.1, 0.006, 0.009)
    assert beam.area == pytest.approx(2 * 0.1 * 0.009 + 0.182 * 0.006)
    assert beam.inertia_z == pytest.approx(2 * (0.1 * 0.009**3 / 12 + 0.1 * 0.009 * 0.0955**2) + 0.006 * 0.182**3 / 12)


def test_profiles_of_nastran(read):
    """Up is local y: DIM2 of BAR and BOX, the height of I."""
    profiles = {
        "BAR": ("BAR\n,.01,.02\n", rectangle(0.02, 0.01)),
        "BOX": ("BOX\n,.01,.02,.001,.002\n", box(0.02, 0.01, 0.001, 0.002)),
        "I": ("I\n,.02,.01,.01,.001,.002,.002\n", double_tee(0.02, 0.01, 0.001, 0.002)),
        "TUBE": ("TUBE\n,.01,.009\n", tube(0.01, 0.001)),
        "TUBE2": ("TUBE2\n,.01,.001\n", tube(0.01, 0.001)),
        "ROD": ("ROD\n,.01\n", tube(0.01)),
    }
    for text, wanted in profiles.values():
        for card in ("PBARL", "PBEAML"):
            mesh = read(".bdf", deck(f"MAT1,1,7.+10,,.33,2700.\n{card},1,1,,{text}"))
            for name, value in wanted._asdict().items():
                assert mesh.sections["pid1"].values[name] == pytest.approx(value, rel=1e-12)


def test_shear_modulus_and_weight(read):
    """E and G of a beam make the ratio; WTMASS scales densities and nonstructural mass; a tube has its wall."""
    bulk = "PARAM,WTMASS,.5\nPBAR,1,1,1.0-4,8.33-10,8.33-10,1.4-9,.1\nMAT1,1,7.+10,2.5+10,,2700.\n"
    values = read(".bdf", deck(bulk)).sections["pid1"].values
    assert values["poisson_ratio"] == pytest.approx(0.4)
    assert (values["density"], values["nonstructural_mass"]) == (1350.0, 0.05)
    rods = "".join(f"CTUBE,{k},1,{k},{k + 1}\n" for k in range(1, 11))
    mesh = read(".bdf", deck("PTUBE,1,1,.02,.001\nMAT1,1,7.+10\n", bars=rods))
    assert mesh.sections["pid1"].values["area"] == pytest.approx(tube(0.01, 0.001).area)


def test_rods_that_state_their_own_section(read):
    rods = "".join(f"CONROD,{k},{k},{k + 1},1,{1 + (k > 5)}.-6\n" for k in range(1, 11))
    mesh = read(".bdf", deck("MAT1,1,7.+10,,,2700.\n", bars=rods))
    assert {name: one.values["area"] for name, one in mesh.sections.items()} == {"conrod1": 1e-6, "conrod2": 2e-6}
    model = mesh.model(cable_tension=1.0)
    assert model.mass == pytest.approx(2700.0 * 0.5 * 3e-6)
    assert len(mesh.groups["conrod"]["cables"]) == 10


def test_sections_of_equal_numbers_are_one_structure(verification_row):
    """Film, cables and frame cut into sections of densities that differ by 1e-13: same runs, full and reduced."""
    whole = antenna((0.59, 1.0), (6, 4))
    given = {group.section.kind: group for group in whole.groups}

    def cut(kind):
        own = given[kind]
        material = replace(own.section.material, density=own.section.material.density * (1.0 + 1e-13))
        half = len(own.connectivity) // 2
        return [own.section] * half + [replace(own.section, material=material)] * (len(own.connectivity) - half)

    model = tf.Model.from_mesh(
        whole.nodes,
        triangles=given["membrane"].connectivity,
        membrane=cut("membrane"),
        membrane_stress=given["membrane"].initial,
        cables=given["cable"].connectivity,
        cable=cut("cable"),
        cable_tension=given["cable"].initial[:, 0],
        beams=given["beam"].connectivity,
        beam=cut("beam"),
        beam_axial_force=given["beam"].initial[:, 0],
        beam_orientation=given["beam"].orientation,
        supports=whole.supports,
        prestress_mode=whole.prestress_mode,
    )
    assert len(model.groups) == 2 * len(whole.groups)
    found = []
    for one in (whole, model):
        state = tf.solve_prestress(one)
        run = {"time_step": 2e-3, "end_time": 0.04, "tolerance": 1e-10, "probes": {"A": (0.5, 0.2)}}
        runs = [tf.simulate(plant, tf.Stop(rate=0.3, duration=0.02), **run) for plant in (state, tf.reduce(state))]
        found.append([tf.solve_modes(state, n=4).frequencies, *(run.data.w.values for run in runs)])
    apart = [np.abs(a - b).max() / np.abs(a).max() for a, b in zip(*found, strict=True)]
    verification_row("structure cut into sections of the same numbers: runs apart", 0.0, max(apart), "one section")
    assert max(apart) < 1e-8
