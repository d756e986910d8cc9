"""A spacecraft of a hub and two wings as Nastran and as Abaqus decks in mm, t, s, and its mass and inertia by hand."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np

X, Y = np.linspace(100.0, 2100.0, 5), np.linspace(-400.0, 400.0, 3)  # of the film [mm]
END, SIDE, HEIGHT = 2200.0, 500.0, 10.0  # of the frame, of the bodies at its tips
FILM, BOOM, STAY = 1.42e-9, 1.6e-9, 1.44e-9  # [t/mm^3]
THICKNESS, AREA, BOX = (0.05, 0.025), 0.8, (30.0, 20.0, 1.0, 1.5)  # of film, stays, booms: across, up, walls
HUB, TIP = (0.05, (20.0, 0.0, -30.0), (4e3, 5e3, 6e3)), (2e-4, (0.5, 0.4, 0.3))  # [t], [mm], [t mm^2]
# Of each wing: where its axes begin, and they as rows: out along x, across along y.
AXES = {
    "a": ((0.0, 600.0, 0.0), np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])),
    "b": ((0.0, -600.0, 0.0), np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])),
}


def wing():
    """Places of points by number, in the wing's axes; quads, stays and booms; points at the root and at the tips."""
    numbers: dict[tuple[float, float], int] = {}

    def point(x, y):
        return numbers.setdefault((float(x), float(y)), len(numbers) + 1)

    cells = [(x, y) for x in pairwise(X) for y in pairwise(Y)]
    quads = [(point(x[0], y[0]), point(x[1], y[0]), point(x[1], y[1]), point(x[0], y[1])) for x, y in cells]
    ring = [(x, -SIDE) for x in (0.0, *X, END)] + [(END, y) for y in Y]
    ring += [(x, SIDE) for x in (END, *X[::-1], 0.0)] + [(0.0, y) for y in Y[::-1]]
    around = [point(*place) for place in ring]
    stays = [(point(x, side * Y[-1]), point(x, side * SIDE)) for x in X for side in (-1.0, 1.0)]
    stays += [(point(X[k], y), point(x, y)) for y in Y for k, x in ((0, 0.0), (-1, END))]
    tips = [point(END, side * SIDE) for side in (-1.0, 1.0)]
    places = {number: place for place, number in numbers.items()}
    return places, quads, stays, list(pairwise([*around, around[0]])), point(0.0, 0.0), tips


def moments():
    """Moments of the boom's section about the axes across and up, and its torsion constant [mm^4], area [mm^2]."""
    wide, high, upper, lateral = BOX
    inner, clear = wide - 2.0 * lateral, high - 2.0 * upper
    across, up = (wide * high**3 - inner * clear**3) / 12.0, (high * wide**3 - clear * inner**3) / 12.0
    torsion = 2.0 * ((wide - lateral) * (high - upper)) ** 2 / ((wide - lateral) / upper + (high - upper) / lateral)
    return across, up, torsion, wide * high - inner * clear


def nastran(folder: Path, *, held: bool) -> Path:
    """Deck with a file for each wing, whose points are in axes of their own; its case control holds the hub or not."""
    places, quads, stays, booms, root, tips = wing()
    half = len(quads) // 2
    lines = ["SOL 103", "CEND", f"SPC = {5 if held else 0}", "BEGIN BULK", "PARAM   GRDPNT  0"]
    for number, (origin, axes) in enumerate(AXES.values(), start=10):
        ends = (*(axes[2] + origin), *(axes[0] + origin))
        lines += [f"CORD2R,{number},,{','.join(map(repr, map(float, (*origin, *ends[:3]))))}"]
        lines += [f",{','.join(map(repr, map(float, ends[3:])))}"]
    mass, offset, inertia = HUB
    lines += ["GRID,1,,0.,0.,0.", f"CONM2,1,1,,{mass},{offset[0]},{offset[1]},{offset[2]}"]
    lines += [f",{inertia[0]},,{inertia[1]},,,{inertia[2]}", "SPC1,5,123456,1", "SPC1,6,123,1"]
    lines += [f"MAT1,1,3000.,,.34,{FILM}", f"MAT1,2,70000.,,.3,{BOOM}", "MAT1*                  3          90000."]
    lines += [f"*       {STAY:>16.8g}", f"PSHELL,1,1,{THICKNESS[0]}", f"PSHELL,2,1,{THICKNESS[1]}", f"PROD,3,3,{AREA}"]
    lines += ["PBARL   4       2               BOX", "        " + "".join(f"{one:<8}" for one in BOX)]
    (folder / "wings").mkdir(exist_ok=True)
    for name, system, first in (("a", 10, 1000), ("b", 11, 2000)):
        lines.append(f"INCLUDE 'wings/{name}.bdf'")
        own = [f"GRID    {first + k:<8}{system:<8}{x:<8}{y:<8}0." for k, (x, y) in places.items()]
        for k, corners in enumerate(quads):
            own.append(f"CQUAD4,{first + k},{1 + k // half},{','.join(str(first + one) for one in corners)}")
        own += [f"CROD,{first + 100 + k},3,{first + a},{first + b}" for k, (a, b) in enumerate(stays)]
        own += [f"CBAR,{first + 200 + k},4,{first + a},{first + b},0.,0.,1." for k, (a, b) in enumerate(booms)]
        own.append(f"RBE2,{first + 300},1,123456,{first + root}")
        for k, one in enumerate(tips):
            own += [f"CONM2,{first + 301 + k},{first + one},{system},{TIP[0]},0.,0.,{HEIGHT}"]
            own += [f",{TIP[1][0]},,{TIP[1][1]},,,{TIP[1][2]}"]
        (folder / "wings" / f"{name}.bdf").write_text("\r\n".join([*own, ""]), encoding="utf-8")
    path = folder / f"{'held' if held else 'free'}.bdf"
    path.write_text("\r\n".join([*lines, "ENDDATA", ""]), encoding="utf-8")
    return path


def abaqus(folder: Path) -> Path:
    """Free spacecraft of one part and two turned instances of it."""
    places, quads, stays, booms, root, tips = wing()
    half, (across, up, torsion, area) = len(quads) // 2, moments()
    lines = ["*PART, NAME=Wing", "*NODE", *(f"{k}, {x!r}, {y!r}, 0." for k, (x, y) in places.items())]
    count = 0
    for name, kind, elements in (
        ("inner", "M3D4", quads[:half]),
        ("outer", "M3D4", quads[half:]),
        ("stays", "T3D2", stays),
        ("booms", "B31", booms),
    ):
        lines.append(f"*ELEMENT, TYPE={kind}, ELSET={name}")
        for corners in elements:
            count += 1
            lines.append(", ".join(map(str, (count, *corners))))
    for k, one in enumerate(tips):
        lines += ["*NODE", f"{900 + k}, {END}, {places[one][1]}, {HEIGHT}", "*MPC", f"BEAM, {900 + k}, {one}"]
    lines += ["*ELEMENT, TYPE=MASS, ELSET=tips", "901, 900", "902, 901", "*MASS, ELSET=tips", str(TIP[0])]
    lines += ["*ELEMENT, TYPE=ROTARYI, ELSET=turns", "903, 900", "904, 901", "*ROTARY INERTIA, ELSET=turns"]
    lines += [", ".join(map(str, TIP[1])), "*NSET, NSET=root", str(root)]
    for name, thickness in zip(("inner", "outer"), THICKNESS, strict=True):
        lines += [f"*MEMBRANE SECTION, ELSET={name}, MATERIAL=film", str(thickness)]
    lines += ["*SOLID SECTION, ELSET=stays, MATERIAL=stay", str(AREA)]
    lines += [f"*BEAM GENERAL SECTION, ELSET=booms, SECTION=GENERAL, DENSITY={BOOM}"]
    lines += [f"{area!r}, {up!r}, 0., {across!r}, {torsion!r}", "0., 0., 1.", f"70000., {70000 / 2.6!r}", "*END PART"]
    lines.append("*ASSEMBLY, NAME=all")
    for name, angle in (("a", 90.0), ("b", -90.0)):
        y = AXES[name][0][1]
        lines += [f"*INSTANCE, NAME={name}, PART=Wing", f"0., {y}, 0.", f"0., {y}, 0., 0., {y}, 1., {angle}"]
        lines.append("*END INSTANCE")
    mass, offset, inertia = HUB
    lines += ["*NODE", "1, 0., 0., 0.", f"2, {', '.join(map(str, offset))}", "*MPC", "BEAM, 2, 1"]
    lines += ["*ELEMENT, TYPE=MASS, ELSET=bus", "1, 2", "*MASS, ELSET=bus", str(mass)]
    lines += ["*ELEMENT, TYPE=ROTARYI, ELSET=busy", "2, 2", "*ROTARY INERTIA, ELSET=busy", ", ".join(map(str, inertia))]
    lines += [
        "*SURFACE, TYPE=NODE, NAME=roots",
        "a.root",
        "b.root",
        "*COUPLING, CONSTRAINT NAME=c, REF NODE=1, SURFACE=roots",
    ]
    lines += ["*KINEMATIC", "1, 6", "*END ASSEMBLY"]
    for name, young, ratio, density in (("film", 3000.0, 0.34, FILM), ("stay", 90000.0, 0.3, STAY)):
        lines += [f"*MATERIAL, NAME={name}", "*ELASTIC", f"{young}, {ratio}", "*DENSITY", str(density)]
    path = folder / "free.inp"
    path.write_text("\n".join([*lines, "*STEP", "*FREQUENCY", "9", "*END STEP", ""]), encoding="utf-8")
    return path


def stated():
    """Mass [kg], first moments [kg m] and inertia about the hub [kg m^2] of what the decks state."""
    places, quads, stays, booms, _, tips = wing()
    across, up, _, area = moments()
    points, own = list[tuple[float, np.ndarray]](), np.diag(HUB[2]).astype(float)
    points.append((HUB[0], np.array(HUB[1])))
    gauss = np.array([-1.0, 1.0]) / np.sqrt(12.0) + 0.5  # exact for products of coordinates
    for origin, axes in AXES.values():
        at = {k: origin + x * axes[0] + y * axes[1] for k, (x, y) in places.items()}
        for k, (a, b, _, d) in enumerate(quads):
            u, v = at[b] - at[a], at[d] - at[a]
            mass = FILM * THICKNESS[k // (len(quads) // 2)] * np.linalg.norm(np.cross(u, v))
            points += [(mass / 4.0, at[a] + s * u + t * v) for s in gauss for t in gauss]
        for lines, per_length in ((stays, STAY * AREA), (booms, BOOM * area)):
            for a, b in lines:
                mass = per_length * np.linalg.norm(at[b] - at[a])
                points += [(mass / 2.0, at[a] + s * (at[b] - at[a])) for s in gauss]
        for a, b in booms:  # sections of linear beams resist twist alone
            along = at[b] - at[a]
            own += BOOM * (across + up) * np.outer(along, along) / np.linalg.norm(along)
        for one in tips:
            points.append((TIP[0], at[one] + HEIGHT * axes[2]))
            own += axes.T @ np.diag(TIP[1]) @ axes
    second = sum(mass * np.outer(place, place) for mass, place in points)
    whole = np.trace(second) * np.eye(3) - second + own
    return 1e3 * sum(mass for mass, _ in points), sum(mass * place for mass, place in points), 1e-3 * whole
