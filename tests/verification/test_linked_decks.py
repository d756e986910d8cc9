"""Links, springs, offsets and pin flags of other programs' files: the mast with known frequencies."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import tautflex as tf
from tautflex import MeshError
from verification import decks
from verification.decks import CLAMPED_FREE, TUBE, beam_frequency, frequencies

OUTER = ",".join(map(str, range(7, 12)))
COUPLED = "*Surface, type=NODE, name=s\ntip\n*Coupling, constraint name=c, ref node=6, surface=s\n"
# Of a rigid outer half, of an inner half with the tip fixed to its end, of the tip held to the middle across.
RIGID, JOINED, ACROSS = 8.438, 8.43358, 19.72604


LINKS = {
    "RBE2": (".bdf", f"RBE2,90,6,123456,{OUTER}\n", RIGID),
    "RBE2 with a range": (".bdf", "RBE2,90,6,123456,7,THRU,11,1.-5\n", RIGID),
    "RBE1": (".bdf", "RBE1,90,6,123456\n,UM,7,123456,8,123456,9,123456\n,,10,123456,11,123456\n", RIGID),
    "RBAR": (".bdf", "RBAR,90,6,11,123456\n", JOINED),
    "RBAR backwards": (".bdf", "RBAR,90,11,6,,123456,123456\n", JOINED),
    "MPC": (".bdf", "MPC,3,11,2,1.,6,2,-1.\n", ACROSS),
    "RIGID BODY": (".inp", "*Rigid Body, ref node=6, elset=outer\n", RIGID),
    "MPC BEAM": (".inp", "*MPC\nBEAM, 11, 6\n", JOINED),
    "COUPLING": (".inp", f"{COUPLED}*Kinematic\n", JOINED),
    "KINEMATIC COUPLING": (".inp", "*Kinematic coupling, ref node=6\ntip, 1, 6\n", JOINED),
    "EQUATION": (".inp", "*Equation\n2\n11,2,1.,6,2,-1.\n", ACROSS),
    "MPC PIN": (
        ".inp",
        "*Node\n50, 1., 0., 0.\n51, 1., 0., .2\n*Element, type=B31\n50, 50, 51\n*MPC\nPIN, 50, 11\n",
        None,
    ),
}


@pytest.mark.parametrize("name", LINKS)
def test_links(name, read):
    suffix, text, wanted = LINKS[name]
    control = "SPC = 1\nMPC = 3\n" if name == "MPC" else "SPC = 1\n"
    mesh = read(suffix, decks.nastran(decks.HELD + text, control=control) if suffix == ".bdf" else decks.abaqus(text))
    if wanted is None:
        # A bar hung by a hinge: it swings freely.
        assert frequencies(mesh, 3)[0] < 1e-2
        return
    # What joins the tip to the middle across leaves the other plane as it is.
    first = beam_frequency(CLAMPED_FREE) if wanted == ACROSS else wanted
    assert frequencies(mesh) == pytest.approx([first, wanted], rel=3e-5)


def test_offset_and_pins(read, verification_row):
    """3.655 Hz: half a metre more of mast; 32.894 Hz: a hinge in the middle of a clamped beam."""
    mesh = read(".bdf", decks.nastran(bars=decks.BARS + ",,,0.,0.,0.,0.5,0.,0.\n"))
    wanted = beam_frequency(CLAMPED_FREE, 1.5)
    found = frequencies(mesh)[0]
    verification_row("deck, CBAR with an offset of 0.5 m at its end [Hz]", wanted, found, "closed form")
    assert wanted == pytest.approx(3.655, abs=5e-4)
    assert found == pytest.approx(wanted, rel=3e-4)  # the last bar is 0.6 m long
    hinged = decks.BARS.replace("CBAR,5,1,5,6,0.,0.,1.", "CBAR,5,1,5,6,0.,0.,1.\n,,56")
    mesh = read(".bdf", decks.nastran("SPC1,1,123456,1,11\n", bars=hinged))
    wanted = beam_frequency(CLAMPED_FREE, 0.5)
    found = frequencies(mesh)[0]
    verification_row("deck, pin flags 56 in the middle of a clamped beam [Hz]", wanted, found, "closed form")
    assert wanted == pytest.approx(32.894, abs=1e-3)
    assert found == pytest.approx(wanted, rel=1e-4)


SPRINGS = {
    "CELAS2": (".bdf", "CELAS2,80,100.,11,2\n"),
    "CELAS1": (".bdf", "PELAS,5,100.\nCELAS1,80,5,11,2,0\n"),
    "CBUSH": (".bdf", "PBUSH,5,K,0.,100.\nCBUSH,80,5,11,,,,,0\n"),
    "CBUSH across": (".bdf", "GRID,50,,1.,.5,0.\nPBUSH,5,K,100.\nCBUSH,80,5,11,50\nSPC1,1,123456,50\n"),
    "SPRING1": (".inp", "*Element, type=SPRING1, elset=s\n80, 11\n*Spring, elset=s\n2\n100.\n"),
    "SPRINGA": (
        ".inp",
        "*Node\n50, 1., .5, 0.\n51, 1.2, .5, 0.\n*Element, type=B31\n70, 50, 51\n*Boundary\n50, 1, 6\n"
        "*Element, type=SPRINGA, elset=s\n80, 11, 50\n*Spring, elset=s\n\n100.\n",
    ),
}


@pytest.mark.parametrize("name", SPRINGS)
def test_springs_at_the_tip(name, read):
    """EI b^3 (1 + cos b cosh b) + k L^3 (cosh b sin b - sinh b cos b) = 0 for k = 100 N/m across: 10.2232 Hz."""
    bending = 7e10 * 8.33e-10

    def balance(b: float) -> float:
        tip = np.cosh(b) * np.sin(b) - np.sinh(b) * np.cos(b)
        return bending * b**3 * (1.0 + np.cos(b) * np.cosh(b)) + 100.0 * tip

    root = brentq(balance, 1.6, 3.0)
    suffix, text = SPRINGS[name]
    mesh = read(suffix, decks.nastran(decks.HELD + text) if suffix == ".bdf" else decks.abaqus(text))
    found = frequencies(mesh)
    assert found[0] == pytest.approx(beam_frequency(CLAMPED_FREE), rel=1e-5)
    assert found[1] == pytest.approx(beam_frequency(root**2), rel=1e-4)


DAMPERS = {
    "CDAMP2": (".bdf", "CDAMP2,80,.3,11,2\n"),
    "CDAMP1": (".bdf", "PDAMP,4,.1,5,.3\nCDAMP1,80,5,11,2,0\n"),
    "CBUSH": (".bdf", "PBUSH,5,B,0.,.3\nCBUSH,80,5,11,,,,,0\n"),
    "CVISC": (
        ".bdf",
        "GRID,50,,1.,.5,0.\nGRID,51,,1.2,.5,0.\nCBAR,70,1,50,51,0.,0.,1.\nSPC1,1,123456,50\n"
        "PVISC,5,.3\nCVISC,80,5,11,50\n",
    ),
    "DASHPOT1": (".inp", "*Element, type=DASHPOT1, elset=s\n80, 11\n*Dashpot, elset=s\n2\n.3\n"),
    "DASHPOT2": (
        ".inp",
        "*Node\n50, 1., .5, 0.\n51, 1.2, .5, 0.\n*Element, type=B31\n70, 50, 51\n*Boundary\n50, 1, 6\n"
        "*Element, type=DASHPOT2, elset=s\n80, 11, 50\n*Dashpot, elset=s\n2, 2\n.3\n",
    ),
    "DASHPOTA": (
        ".inp",
        "*Node\n50, 1., .5, 0.\n51, 1.2, .5, 0.\n*Element, type=B31\n70, 50, 51\n*Boundary\n50, 1, 6\n"
        "*Element, type=DASHPOTA, elset=s\n80, 11, 50\n*Dashpot, elset=s\n\n.3\n",
    ),
}


@pytest.mark.parametrize("name", DAMPERS)
def test_dampers_at_the_tip(name, read):
    """Across the tip, by its velocity; a deck in t, mm, s has them a thousandth in number."""
    suffix, text = DAMPERS[name]
    mesh = read(suffix, decks.nastran(decks.HELD + text) if suffix == ".bdf" else decks.abaqus(text))
    assert not mesh.springs
    vectors, values = tf.solve_prestress(mesh.model(beam=TUBE)).system.dampers
    model = mesh.model(beam=TUBE)
    tip = int(np.argmax((model.nodes[:, 0] == 1.0) & (model.nodes[:, 1] == 0.0)))
    assert values == pytest.approx([0.3])
    assert np.abs(vectors[0, model.free_places[model.dof_offset[tip] + 1]]) == pytest.approx(1.0)
    assert np.count_nonzero(vectors) == 1


@pytest.mark.parametrize(
    ("suffix", "text", "words"),
    [
        (".bdf", "RBE2,90,6,123456,12\n", "expected an existing grid point, got 12"),
        (".bdf", "RBE2,90,6,123456,1\n", "held by a support too"),
        (".bdf", "RBE2,90,6,123456,7\nRBE2,91,5,123456,7\n", "to follow one link"),
        (".bdf", "RBAR,90,6,11,123,456\n", "expected 123456 independent at one end"),
        (".bdf", "RBE3,90,,6,123,1.,1234,7,8\n", "expected components 123"),
        (".bdf", "CELAS2,80,100.,11,2,10,3\n", "expected the same component"),
        (".bdf", "CBUSH,80,5,11\nPBUSH,5,K,1.\n", "expected CID"),
        (".bdf", "PBUSH,5,M,1.\nCBUSH,80,5,11,,,,,0\n", "expected no M"),
        (".bdf", "CDAMP1,80,5,11,2\n", "expected a PDAMP 5"),
        (".bdf", "PVISC,5,1.\nCVISC,80,5,11,11\n", "expected points at two places"),
        (".bdf", "MPC,3,11,2,1.,6,2,-1.\n", "expected MPC = number"),
        (".inp", "*MPC\nLINK, 11, 6\n", "expected BEAM, TIE, PIN"),
        (".inp", "*Equation\n3\n11,2,1.,6,2,-1.\n", "expected 3 terms"),
        (".inp", "*Coupling, constraint name=c, ref node=6, surface=s\n*Kinematic\n", "expected a *SURFACE"),
        (".inp", COUPLED, "*KINEMATIC or *DISTRIBUTING"),
        (".inp", "*Element, type=SPRING2, elset=s\n80, 11, 10\n*Spring, elset=s\n1, 2\n100.\n", "the same direction"),
    ],
)
def test_refused_by_name(suffix, text, words, read):
    def build() -> None:
        read(suffix, decks.nastran(decks.HELD + text) if suffix == ".bdf" else decks.abaqus(text)).model(beam=TUBE)

    with pytest.raises(MeshError) as caught:
        build()
    assert words in str(caught.value)


def test_units_of_links_and_springs(read):
    """The same mast in t, mm, s."""
    grids = "".join(f"GRID,{k + 1},,{100 * k},0.0,0.0\n" for k in range(11))
    links = "PBUSH,5,K,0.,0.1,0.,0.,0.,2.+6\nCBUSH,80,5,11,,,,,0\nMPC,3,10,6,1.,9,2,-.001\n"
    small = decks.nastran(decks.HELD + links, control="SPC = 1\nMPC = 3\n", grids=grids)
    found = frequencies(read(".bdf", small, unit_length=1e-3, unit_mass=1e3), 3)
    links = "PBUSH,5,K,0.,100.,0.,0.,0.,2.+3\nCBUSH,80,5,11,,,,,0\nMPC,3,10,6,1.,9,2,-1.\n"
    wanted = frequencies(read(".bdf", decks.nastran(decks.HELD + links, control="SPC = 1\nMPC = 3\n")), 3)
    assert found == pytest.approx(wanted, rel=1e-9)
    with pytest.raises(MeshError, match="expected unit_mass beside unit_length"):
        read(".bdf", small, unit_length=1e-3)
    dampers = "PBUSH,5,B,0.,3.-4,0.,0.,0.,2.+3\nCBUSH,80,5,11,,,,,0\n"  # t/s, and t mm^2/s
    mesh = read(".bdf", decks.nastran(decks.HELD + dampers, grids=grids), unit_length=1e-3, unit_mass=1e3)
    assert sorted(mesh.model(beam=TUBE).dampers[0].values) == pytest.approx([0.0, 0.0, 0.0, 0.0, 0.3, 2.0])


def test_payload_on_a_distributing_link(read):
    """A body on the average of three points: mass and inertia as given, six rigid modes of the free structure."""
    text = (
        "GRID,20,,1.,.2,0.\nCBAR,20,1,11,20,0.,0.,1.\nGRID,50,,1.1,.1,.2\nCONM2,70,50,,2.5\n,.1,,.1,,,.1\n"
        "RBE3,91,,50,123456,1.0,123,10,11\n,20\n"
    )
    model = read(".bdf", decks.nastran(text, control="SPC = 0\n")).model(beam=TUBE)
    assert model.mass == pytest.approx(2.5 + 0.27 * 1.2)
    found = tf.solve_modes(tf.solve_prestress(model), n=7).frequencies
    assert np.all(found[:6] < 1e-3)
    assert found[6] > 0.5
