"""Mesh of the template `sail`: a triangular solar sail on three booms, of any size and fineness.

Run ``python examples/sail_mesh.py sail.inp`` beside a case of ``tautflex init --template sail``. The film's edges are
arcs of one radius, so that cords of one tension hold a uniform film: tension = film resultant x radius.
"""

from __future__ import annotations

import argparse
from itertools import pairwise
from pathlib import Path

import numpy as np


def arc(start: np.ndarray, end: np.ndarray, radius: float, count: int) -> np.ndarray:
    """Points of an arc from start to end that bends to the left, evenly spaced, shape (count + 1, 2)."""
    chord = end - start
    length = float(np.hypot(*chord))
    half = np.arcsin(0.5 * length / radius)
    along, left = chord / length, np.array([-chord[1], chord[0]]) / length
    angle = np.linspace(-half, half, count + 1)
    sag = radius * (np.cos(angle) - np.cos(half))
    middle = 0.5 * (start + end)
    return middle + radius * np.sin(angle)[:, None] * along + sag[:, None] * left


def sail(size: float, radius: float, depth: float, count: int) -> dict[str, np.ndarray]:
    """Nodes [m] and elements; the last node is the hub, from which booms run to the corners."""
    angles = 2.0 * np.pi * np.arange(3) / 3.0
    corners = size * np.array([np.cos(angles), np.sin(angles)]).T
    sides = [arc(corners[k], corners[(k + 1) % 3], radius, count) for k in range(3)]
    number, points = {}, []
    for i in range(count + 1):
        for j in range(count + 1 - i):
            # Weights of the corners; what the sides bend by is blended into the film.
            weights = np.array([count - i - j, i, j]) / count
            place = weights @ corners
            for k in range(3):
                one, other = weights[k], weights[(k + 1) % 3]
                if one + other > 0.0:
                    share = other / (one + other)
                    at = share * count
                    low = min(int(at), count - 1)
                    point = sides[k][low] + (at - low) * (sides[k][low + 1] - sides[k][low])
                    place = place + (one + other) ** 2 * (
                        point - (1 - share) * corners[k] - share * corners[(k + 1) % 3]
                    )
            number[i, j] = len(points)
            points.append(place)
    triangles = [(number[i, j], number[i + 1, j], number[i, j + 1]) for i in range(count) for j in range(count - i)] + [
        (number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]) for i in range(count) for j in range(count - 1 - i)
    ]
    edges = [
        [(i, 0) for i in range(count + 1)],
        [(count - j, j) for j in range(count + 1)],
        [(0, j) for j in range(count + 1)],
    ]
    cords = [(number[a], number[b]) for edge in edges for a, b in pairwise(edge)]
    nodes = np.pad(np.array(points), ((0, 0), (0, 1)))
    hub, beams = len(nodes) + 3 * (count - 1), []
    for tip in (number[0, 0], number[count, 0], number[0, count]):
        line = [*range(len(nodes), len(nodes) + count - 1)]
        share = np.arange(1, count)[:, None] / count
        nodes = np.concatenate([nodes, share * nodes[tip] - (1.0 - share) * [0.0, 0.0, depth]])
        beams += zip([hub, *line], [*line, tip], strict=True)
    nodes = np.concatenate([nodes, [[0.0, 0.0, -depth]]])
    return {"nodes": nodes, "M3D3": np.array(triangles), "T3D2": np.array(cords), "B31": np.array(beams)}


def abaqus(mesh: dict[str, np.ndarray]) -> str:
    """The mesh as an Abaqus input file."""
    lines = ["** A triangular solar sail, lengths in m: film, edge cords, booms; the last node is the hub.", "*NODE"]
    lines += [f"{k}, {x:.9g}, {y:.9g}, {z:.9g}" for k, (x, y, z) in enumerate(mesh["nodes"], start=1)]
    first = 1
    for name, kind in (("film", "M3D3"), ("cables-edge", "T3D2"), ("beams-boom", "B31")):
        lines.append(f"*ELEMENT, TYPE={kind}, ELSET={name}")
        for number, nodes in enumerate(mesh[kind] + 1, start=first):
            lines.append(", ".join(map(str, (number, *nodes))))
        first += len(mesh[kind])
    return "\n".join([*lines, "*NSET, NSET=support-hub", f"{len(mesh['nodes'])}", ""])


def main() -> None:
    """Write the mesh."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path, help="Abaqus file to write (.inp)")
    parser.add_argument("--size", type=float, default=2.0, help="length of the booms [m]")
    parser.add_argument("--radius", type=float, default=8.0, help="radius of the edges [m]")
    parser.add_argument("--depth", type=float, default=0.05, help="hub behind the film [m]")
    parser.add_argument("--count", type=int, default=12, help="elements on each edge")
    asked = parser.parse_args()
    asked.file.write_text(abaqus(sail(asked.size, asked.radius, asked.depth, asked.count)), encoding="utf-8")


if __name__ == "__main__":
    main()
