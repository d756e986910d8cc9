"""Frequencies of decks as other programs write them, against closed forms; what is not read is refused by name."""

from __future__ import annotations

import numpy as np
import pytest

from regression import mesh_files
from tautflex import MeshError
from verification import decks
from verification.decks import CLAMPED_CLAMPED, CLAMPED_FREE, TUBE, beam_frequency, frequencies, tip_mass_frequency

EULER = "Euler-Bernoulli beam"


REPLICATED = "GRID,1,,0.,0.,0.\nGRID,2,,.1,0.,0.\n=,*(1),=,*(.1),==\n=(8)\n"
REPLICATED_BARS = "CBAR,1,1,1,2,0.,0.,1.\n=,*(1),=,*(1),*(1),==\n=(8)\n"
SYSTEM = "CORD2R,5,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n"
DOCKED = "$ second load case, docked\nSPC1,2,123456,1,11\n"
BOTH_SETS = "*Nset, nset=Set-1, generate\n1, {last}, 1\n*Elset, elset=Set-1, generate\n1, 5, 1\n"
ROOT = "*Nset, nset=Set-1, instance=Mast-1\n1,\n"
TURNED = "*Transform, nset=tip, type=R\n0.,1.,0.,-1.,0.,0.\n"
STEPS = "*Step, nlgeom\n*Static\n1.,1.\n*End Step\n*Step, perturbation\n*Frequency\n4\n{held}*End Step\n"

MASTS = {
    "set chosen by the case control": (".bdf", decks.nastran(decks.HELD + DOCKED), CLAMPED_FREE),
    "the other set": (".bdf", decks.nastran(decks.HELD + DOCKED, control="SPC = 2\n"), CLAMPED_CLAMPED),
    "set of sets": (
        ".bdf",
        decks.nastran("SPCADD,9,1,2\n" + decks.HELD + DOCKED, control="SPC = 9\n"),
        CLAMPED_CLAMPED,
    ),
    "replication": (".bdf", decks.nastran(grids=REPLICATED, bars=REPLICATED_BARS), CLAMPED_FREE),
    "unused system": (".bdf", decks.nastran(decks.HELD + SYSTEM), CLAMPED_FREE),
    "damaged unused system": (".bdf", decks.nastran(decks.HELD + "CORD2R,5,,0.,0.\n"), CLAMPED_FREE),
    "used system": (
        ".bdf",
        decks.nastran(decks.HELD + SYSTEM, grids=decks.GRIDS.replace("GRID,5,,", "GRID,5,5,")),
        CLAMPED_FREE,
    ),
    "set of the assembly": (".inp", decks.assembled(BOTH_SETS.format(last=6), ROOT, "Set-1, 1, 6\n"), CLAMPED_FREE),
    "set of all nodes in the part": (
        ".inp",
        decks.assembled(BOTH_SETS.format(last=11), ROOT, "Set-1, 1, 6\n"),
        CLAMPED_FREE,
    ),
    "reference point": (
        ".inp",
        decks.assembled(
            "", "*Node\n1, 0.5, 0., 0.\n*Nset, nset=RP\n1,\n*Nset, nset=root, instance=Mast-1\n1,\n", "root, encastre\n"
        ),
        CLAMPED_FREE,
    ),
    "OP=NEW": (
        ".inp",
        decks.abaqus("", "*Boundary\nroot,1,6\ntip,1,6\n", STEPS.format(held="*Boundary, op=NEW\nroot,1,6\n")),
        CLAMPED_FREE,
    ),
    "conditions of earlier steps stay": (
        ".inp",
        decks.abaqus("", "*Boundary\nroot,1,6\n", STEPS.format(held="*Boundary\ntip,1,6\n")),
        CLAMPED_CLAMPED,
    ),
}


@pytest.mark.parametrize("name", MASTS)
def test_masts(name, read, verification_row):
    suffix, text, factor = MASTS[name]
    found = frequencies(read(suffix, text))[0]
    wanted = beam_frequency(factor)
    verification_row(f"deck, {name}: first frequency [Hz]", wanted, found, EULER)
    assert found == pytest.approx(wanted, rel=2e-5 if factor == CLAMPED_FREE else 3e-4)


def test_directions_of_supports_turn_with_the_axes_of_the_nodes(read, verification_row):
    """The tip is held along y, which the file calls x: 3.92660231^2 is the first root of a clamped-pinned beam."""
    mesh = read(".inp", decks.abaqus(TURNED, "*Boundary\nroot, encastre\ntip, 1\n"))
    found, wanted = frequencies(mesh), [beam_frequency(CLAMPED_FREE), beam_frequency(3.92660231**2)]
    assert mesh.supports[1].directions == ("y",)
    verification_row("deck, TRANSFORM at the tip: second frequency [Hz]", wanted[1], found[1], EULER)
    np.testing.assert_allclose(found, wanted, rtol=2e-4)
    turned = decks.GRIDS.replace("GRID,11,,1.0,0.0,0.0", "GRID,11,,1.0,0.0,0.0,7")
    system = "CORD2R,7,,0.,0.,0.,0.,0.,1.\n,0.,1.,0.\nSPC1,1,1,11\n"
    again = read(".bdf", decks.nastran(decks.HELD + system, grids=turned))
    np.testing.assert_allclose(frequencies(again), found, rtol=1e-12)


def test_permanent_constraints_by_default(read, verification_row):
    """A hinged planar beam of 2 m: GRDSET holds 345 of every point that does not say otherwise."""
    grids = (
        "GRDSET"
        + " " * 50
        + "345\n"
        + "".join(f"GRID    {k + 1:<8}        {k / 10:<8}0.0     0.0\n" for k in range(21))
    )
    bars = "".join(f"CBAR    {k:<8}1       {k:<8}{k + 1:<8}0.0     1.0     0.0\n" for k in range(1, 21))
    mesh = read(
        ".bdf", decks.nastran("SPC1    1       12      1\nSPC1    1       2       21\n", grids=grids, bars=bars)
    )
    wanted = beam_frequency(np.pi**2, 2.0)
    assert frequencies(mesh)[0] == pytest.approx(wanted, rel=1e-5)
    load = 0.5 * np.pi**2 * TUBE.material.youngs_modulus * TUBE.inertia_y / 4.0
    found = frequencies(mesh, beam_axial_force=-load)[0]
    verification_row("deck, GRDSET: hinged beam under half the Euler load [Hz]", np.sqrt(0.5) * wanted, found, EULER)
    assert found == pytest.approx(np.sqrt(0.5) * wanted, rel=1e-5)


def test_wings_that_are_held_each(read, verification_row):
    grids = "".join(
        f"GRID,{k},,{x},0.,0.\n" for k, x in [(1, 0.5), (2, 1.5), (3, 2.5), (11, -0.5), (12, -1.5), (13, -2.5)]
    )
    bars = "".join(f"CBAR,{a},1,{a},{a + 1},0.,0.,1.\n" for a in (1, 2, 11, 12))
    wings = decks.nastran("SPC1,1,123456,1,11\n", grids=grids, bars=bars)
    found = frequencies(read(".bdf", wings), n=4)
    wanted = beam_frequency(CLAMPED_FREE, 2.0)
    verification_row("deck, two wings: first four frequencies [Hz], all alike", wanted, found.max(), EULER)
    np.testing.assert_allclose(found, wanted, rtol=1e-3)
    with pytest.raises(MeshError, match=r"2 pieces, .* leave one \(3 node\(s\), e.g. node 3\) 6 rigid motions free"):
        read(".bdf", wings.replace("123456,1,11", "123456,1")).model(beam=TUBE)


def test_strut_between_two_masts(read):
    """5.789 Hz with the strut, 8.2237 Hz if it were left out."""
    grids = "".join(f"GRID,{k + 1 + 100 * s},,0.,{s / 2},{k / 5}\n" for s in (0, 1) for k in range(6))
    bars = "".join(
        f"CBAR,{k + 100 * s},1,{k + 100 * s},{k + 1 + 100 * s},1.,0.,0.\n" for s in (0, 1) for k in range(1, 6)
    )
    bars += "CBAR,90,1,1,101,1.,0.,0.\n"
    held = "SPC1,1,123456,1,101\n"
    portal = decks.nastran(held + "CBAR,91,1,6,106,1.,0.,0.\n", grids=grids, bars=bars)
    assert frequencies(read(".bdf", portal))[0] == pytest.approx(5.789, abs=1e-3)
    for card in ("CBEAM3,91,2,6,106,300,1.,0.,0.", "RSPLINE,91,,6,106", "CGAP,91,1,6,106", "GENEL,91", "DMIG,K"):
        with pytest.raises(MeshError, match=rf"line \d+ \('{card.partition(',')[0]}'\): not read here"):
            read(".bdf", decks.nastran(f"{held}{card}\n", grids=grids, bars=bars))


def test_film_of_quads(read, verification_row):
    """Square of 1 m, all edges held: f = sqrt(sigma / rho / 2), of which bilinear elements of 2 x 2 cells are far."""
    cells = 16
    grids = "".join(
        f"GRID,{1 + i + (cells + 1) * j},,{i / cells},{j / cells},0.\n"
        for j in range(cells + 1)
        for i in range(cells + 1)
    )
    quads = "".join(
        f"CQUAD4,{1 + i + cells * j},1,{a},{a + 1},{a + cells + 2},{a + cells + 1}\n"
        for j in range(cells)
        for i in range(cells)
        for a in [1 + i + (cells + 1) * j]
    )
    edge = [1 + i + (cells + 1) * j for j in range(cells + 1) for i in range(cells + 1) if {i, j} & {0, cells}]
    held = "".join(f"SPC1,1,123,{node}\n" for node in edge)
    mesh = read(".bdf", decks.nastran(held, grids=grids, bars=quads))
    assert mesh.quads.shape == (cells**2, 4)
    wanted = np.sqrt(0.5 * 1e6 / 1530.0)
    found = frequencies(mesh)[0]
    verification_row("deck, CQUAD4: square film with fixed edges [Hz]", wanted, found, "sqrt(sigma / (2 rho)) / L")
    assert found == pytest.approx(wanted, rel=5e-3)


@pytest.mark.skipif(not mesh_files.gmsh_starts(), reason="needs Gmsh, of the extra tautflex[mesh]")
def test_ungrouped_surfaces_leave_no_holes(read):
    """Six triangles and two quadrilaterals of 5 m2 in no group; a group of one of them leaves a group of the rest."""
    points = [(x, y) for y in range(3) for x in range(4)]
    cells = ["2 1 2 6", "2 1 6 5", "2 5 6 10", "2 5 10 9", "2 2 3 7", "2 2 7 6", "3 6 7 11 10", "3 7 8 12 11"]
    rim = ["1 1 2", "1 2 3", "1 3 4", "1 4 8", "1 8 12", "1 12 11", "1 11 10", "1 10 9", "1 9 5", "1 5 1"]

    def deck(group_of_first):
        lines = [
            "$MeshFormat",
            "2.2 0 8",
            "$EndMeshFormat",
            "$PhysicalNames",
            "2",
            '1 1 "fixed_edge"',
            '2 2 "membrane"',
        ]
        lines += ["$EndPhysicalNames", "$Nodes", "12", *(f"{k} {x} {y} 0" for k, (x, y) in enumerate(points, start=1))]
        lines += ["$EndNodes", "$Elements", str(len(rim) + len(cells))]
        groups = [1] * len(rim) + [group_of_first] + [0] * (len(cells) - 1)
        for number, (group, cell) in enumerate(zip(groups, rim + cells, strict=True), start=1):
            kind, _, nodes = cell.partition(" ")
            lines.append(f"{number} {kind} 2 {group} {1 if number <= len(rim) + 1 else 2} {nodes}")
        return "\n".join([*lines, "$EndElements", ""])

    def area(mesh):
        return mesh.model(membrane=decks.FILM).mass / (1530.0 * 1e-4)

    assert area(read(".msh", deck(0))) == pytest.approx(5.0)
    with pytest.raises(MeshError, match=r"group 'ungrouped': .*names=\{'ungrouped': 'membrane'\}"):
        read(".msh", deck(2))
    assert area(read(".msh", deck(2), names={"ungrouped": "membrane"})) == pytest.approx(5.0)


PAYLOADS = {
    "CONM2": (".bdf", decks.nastran(decks.HELD + "CONM2,90,11,,2.5\n")),
    "CMASS1": (
        ".bdf",
        decks.nastran(decks.HELD + "PMASS,7,2.5\n" + "".join(f"CMASS1,{75 + k},7,11,{k}\n" for k in (1, 2, 3))),
    ),
    "MASS": (".inp", decks.abaqus("*Element, type=MASS, elset=payload\n901, 11\n*Mass, elset=payload\n2.5\n")),
}


@pytest.mark.parametrize("name", PAYLOADS)
def test_payload_at_the_tip(name, read, verification_row):
    """1.3147 Hz: 1 + cos b cosh b + (M / m L) b (cos b sinh b - sin b cosh b) = 0."""
    mesh = read(*PAYLOADS[name])
    found, wanted = frequencies(mesh)[0], tip_mass_frequency(2.5 / 0.27)
    verification_row(f"deck, {name} of 2.5 kg at the tip [Hz]", wanted, found, "closed form")
    assert found == pytest.approx(wanted, rel=1e-6)
    assert mesh.model(beam=TUBE).mass == pytest.approx(2.77)


HINGED = decks.BARS.replace("CBAR,5,1,5,6,0.,0.,1.", "CBAR,5,1,5,6,0.,0.,1.\n,,56")
BEYOND = decks.BARS + ",,,0.,0.,0.,0.5,0.,0.\n"
JOINED = {
    "hinge at mid-span": (decks.HELD + "SPC1,1,123456,11\n", HINGED, 4.0 * CLAMPED_FREE, 1.0),
    "end 0.5 m beyond its point": (decks.HELD, BEYOND, CLAMPED_FREE, 1.5),
}


@pytest.mark.parametrize("name", JOINED)
def test_ends_that_are_hinged_or_offset(name, read, verification_row):
    """Pin flags 56 make two cantilevers of half the length, W1B = 0.5 a mast of 1.5 m."""
    held, bars, factor, length = JOINED[name]
    found = frequencies(read(".bdf", decks.nastran(held, bars=bars)))[0]
    wanted = beam_frequency(factor, length)
    verification_row(f"deck, {name}: first frequency [Hz]", wanted, found, EULER)
    assert found == pytest.approx(wanted, rel=1e-3)


def test_a_hinge_turns_with_its_beam(read):
    """The mast along a slanted line, its hinge about one local axis only: the other plane is clamped on both sides."""
    axis = np.array([2.0, 1.0, 2.0]) / 3.0
    grids = "".join(f"GRID,{k + 1},,{x:.12f},{y:.12f},{z:.12f}\n" for k in range(11) for x, y, z in [axis * k / 10])
    bars = decks.BARS.replace("0.,0.,1.", "0.,1.,0.").replace("CBAR,5,1,5,6,0.,1.,0.", "CBAR,5,1,5,6,0.,1.,0.\n,,6")
    mesh = read(".bdf", decks.nastran(decks.HELD + "SPC1,1,123456,11\n", grids=grids, bars=bars))
    found = frequencies(mesh, n=2)
    wanted = sorted([beam_frequency(4.0 * CLAMPED_FREE), beam_frequency(CLAMPED_CLAMPED)])
    np.testing.assert_allclose(found, wanted, rtol=1e-3)


def test_supports_along_slanted_axes(read, verification_row):
    """A mast along a slanted line, its tip held across it in one direction by the displacement system of the point."""
    turn = np.array([[2.0, 1.0, 2.0], [-2.0, 2.0, 1.0], [-1.0, -2.0, 2.0]]) / 3.0
    grids = "".join(
        f"GRID,{k + 1},,{x:.15f},{y:.15f},{z:.15f}" + (",7\n" if k == 10 else "\n")
        for k in range(11)
        for x, y, z in [turn[0] * k / 10]
    )
    z, x = turn[2], turn[0]
    system = f"CORD2R,7,,0.,0.,0.,{z[0]:.15f},{z[1]:.15f},{z[2]:.15f}\n,{x[0]:.15f},{x[1]:.15f},{x[2]:.15f}\n"
    mesh = read(".bdf", decks.nastran(f"{decks.HELD}SPC1,1,2,11\n{system}", grids=grids))
    found, wanted = frequencies(mesh), [beam_frequency(CLAMPED_FREE), beam_frequency(3.92660231**2)]
    verification_row("deck, tip held along a slanted axis: second frequency [Hz]", wanted[1], found[1], EULER)
    np.testing.assert_allclose(found, wanted, rtol=3e-4)
    assert mesh.supports[0].nodes == (0,)


REMOVED = "*Step, nlgeom\n*Static\n1.,1.\n*Model change, remove\nouter\n*End step\n" + decks.STEP
ABAQUS = {
    "2.5 kg in total": ("*Nonstructural mass, elset=outer, units=TOTAL MASS\n2.5\n", decks.STEP, 1.907),
    "5 kg/m": ("*Nonstructural mass, elset=outer, units=MASS PER LENGTH\n5.\n", decks.STEP, 1.907),
    "outer half removed": ("", REMOVED, 32.895),
}


@pytest.mark.parametrize("name", ABAQUS)
def test_masses_and_removals_on_the_outer_half(name, read, verification_row):
    lines, steps, wanted = ABAQUS[name]
    mesh = read(".inp", decks.abaqus(lines, steps=steps))
    found = frequencies(mesh)[0]
    verification_row(f"deck, {name}: first frequency [Hz]", wanted, found, "shared/cases a05")
    assert found == pytest.approx(wanted, rel=3e-4)


REFUSED = {
    **{
        keyword: (".inp", decks.abaqus(lines), f"({keyword.upper()}): not read here")
        for keyword, lines in {
            "connector section": "*Connector section\n",
            "fastener": "*Fastener\n",
            "imperfection": "*Imperfection, file=a, step=1\n",
            "nfill": "*Nfill\nroot, tip, 10\n",
        }.items()
    },
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused_by_name(name, read):
    suffix, text, words = REFUSED[name]
    with pytest.raises(MeshError) as caught:
        read(suffix, text)
    assert words in str(caught.value)
