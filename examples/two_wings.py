"""Deck of a membrane antenna with two wings on one hub, and its cases.

Run ``python examples/two_wings.py two_wings.bdf``: beside the Nastran deck it writes ``two_wings.toml`` for `tautflex
check` and `run`, and ``two_wings_loop.toml`` for `tautflex modes` and `control`, on a free hub. Each wing is a film of
quadrilaterals and triangles that cables hold in a frame of booms. The frames are rigidly linked to the hub's node,
which is free in one case and turns as told in the other; their far corners carry bodies.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from itertools import count, pairwise
from pathlib import Path

HUB = 1  # number of its node
ROOT, LENGTH, WIDTH, GAP = 0.5, 2.0, 1.0, 0.1  # where a wing begins, its frame, film to frame [m]
TIP_MASS, TIP_INERTIA, TIP_OFFSET = 0.05, (2e-5, 3e-5, 4e-5), (0.0, 0.0, 0.02)  # [kg], [kg m^2], [m]

PROPERTIES = """$ polyimide and carbon fibre [Pa, kg/m^3]
MAT1,1,3.+9,,.34,1420.
MAT1,2,70.+9,,.3,1600.
PSHELL,1,1,5.-5
PROD,2,2,5.-7
PBARL,3,2,,TUBE
,.015,.014
"""

CASE = """# A membrane antenna with two wings on a free spacecraft, which turns about the wings. SI units throughout.

schema = 1

[mesh]
file = "{file}"                     # film, cables, booms, their sections, links and bodies at the tips

[membrane]                          # what the deck does not state
strain = "green-lagrange"           # as is right for what turns freely

[cables]
pretension_x = 1.0                  # [N]
pretension_y = 1.0

[prestress]
mode = "equilibrium"

[maneuver]
kind = "slew"
angle = 0.1                         # [rad]
duration = 2.0                      # [s]
axis = [0.0, 1.0, 0.0]

[damping]
alpha = 0.01                        # [1/s]
beta = 1e-3                         # [s]

[solver]
method = "generalized-alpha"
time_step = 0.005                   # [s]
end_time = 4.0                      # [s]

[output.probes]
right = [1.5, 0.0]                  # [m]
left = [-1.5, 0.0]
"""

LOOP = """
[hub]
mass = 60.0                         # [kg]
inertia = [5.0, 6.0, 7.0]           # [kg m^2]

[actuators.torque]
kind = "hub-torque"
axis = "xyz"
limit = 5.0                         # [N m]

[sensors.attitude]
kind = "attitude"

[sensors.rate]
kind = "rate"

[controller]
kind = "pd"
stiffness = 12.0                    # [N m/rad]
damping = 24.0                      # [N m s/rad]
inertia = 12.7                      # of hub and wings [kg m^2]

[loop]
interval = 0.02                     # [s]
"""


def wing(side: int, first: int, cells: tuple[int, int]) -> Iterator[str]:
    """Cards of the wing on the side +1 or -1 of the hub, its points and elements numbered from ``first`` on."""
    points, elements = count(first), count(first)
    along, across = cells
    x = [ROOT + GAP + (LENGTH - 2.0 * GAP) * i / along for i in range(along + 1)]
    y = [GAP - 0.5 * WIDTH + (WIDTH - 2.0 * GAP) * j / across for j in range(across + 1)]
    film, frame = {}, {}
    for i in range(along + 1):
        for j in range(across + 1):
            film[i, j] = next(points)
            yield f"GRID,{film[i, j]},,{side * x[i]:.9g},{y[j]:.9g},0."
    # Round the frame: a point opposite each on the film's edge, and the corners.
    outer = [(x_, -0.5 * WIDTH, (i, 0)) for i, x_ in enumerate(x)] + [(ROOT + LENGTH, -0.5 * WIDTH, None)]
    outer += [(ROOT + LENGTH, y_, (along, j)) for j, y_ in enumerate(y)] + [(ROOT + LENGTH, 0.5 * WIDTH, None)]
    outer += [(x[i], 0.5 * WIDTH, (i, across)) for i in range(along, -1, -1)] + [(ROOT, 0.5 * WIDTH, None)]
    outer += [(ROOT, y[j], (0, j)) for j in range(across, -1, -1)] + [(ROOT, -0.5 * WIDTH, None)]
    for x_, y_, _ in outer:
        frame[x_, y_] = next(points)
        yield f"GRID,{frame[x_, y_]},,{side * x_:.9g},{y_:.9g},0."
    for i in range(along):
        for j in range(across):
            a, b, c, d = film[i, j], film[i + 1, j], film[i + 1, j + 1], film[i, j + 1]
            if i == along - 1:
                yield f"CTRIA3,{next(elements)},1,{a},{b},{c}"
                yield f"CTRIA3,{next(elements)},1,{a},{c},{d}"
            else:
                yield f"CQUAD4,{next(elements)},1,{a},{b},{c},{d}"
    for x_, y_, held in outer:
        if held is not None:
            yield f"CROD,{next(elements)},2,{film[held]},{frame[x_, y_]}"
    around = list(frame.values())
    for a, b in pairwise([*around, around[0]]):
        yield f"CBAR,{next(elements)},3,{a},{b},0.,0.,1."
    for corner in (-0.5, 0.5):
        tip = frame[ROOT + LENGTH, corner * WIDTH]
        yield f"CONM2,{next(elements)},{tip},,{TIP_MASS},{','.join(map(str, TIP_OFFSET))}"
        yield f",{TIP_INERTIA[0]},,{TIP_INERTIA[1]},,,{TIP_INERTIA[2]}"
    yield f"RBE2,{next(elements)},{HUB},123456,{frame[ROOT, y[across // 2]]}"


def deck(cells: tuple[int, int], *, held: bool = True) -> str:
    """The Nastran deck of both wings with so many cells along and across each, its hub held or free."""
    lines = ["SOL 103", "CEND", *(["SPC = 1"] if held else []), "BEGIN BULK", f"GRID,{HUB},,0.,0.,0."]
    lines += [*wing(1, 1001, cells), *wing(-1, 2001, cells), PROPERTIES.rstrip()]
    return "\n".join([*lines, *([f"SPC1,1,123456,{HUB}"] if held else []), "ENDDATA", ""])


def main() -> None:
    """Write the deck and its cases."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path, help="Nastran deck to write (.bdf)")
    parser.add_argument("--cells", type=int, nargs=2, default=(9, 4), help="cells along and across each wing")
    asked = parser.parse_args()
    asked.file.write_text(deck(tuple(asked.cells)), encoding="utf-8")
    for ending, text in ((".toml", CASE), ("_loop.toml", CASE + LOOP)):
        case = asked.file.with_name(asked.file.stem + ending)
        case.write_text(text.format(file=asked.file.name), encoding="utf-8")


if __name__ == "__main__":
    main()
