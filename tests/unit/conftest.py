"""Synthetic antenna data: the paper's geometry, closed-form shapes and motion with known answers."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

LENGTH, WIDTH = 2.0, 1.0
WAVES = [(1, 1), (2, 1), (3, 1), (1, 2), (4, 1), (2, 2)]
FREQUENCIES = [1.0005, 1.2498, 1.6040, 1.9923, 2.0101, 2.1286]  # paper, Table 2


def antenna_mesh(nx: int = 10, ny: int = 5) -> dict[str, np.ndarray]:
    """Membrane 2 m x 1 m, one cable at every edge node, frame 2.5 m x 1.5 m around it."""
    x, y = np.linspace(-1, 1, nx + 1), np.linspace(-0.5, 0.5, ny + 1)
    nodes = [(a, b) for a in x for b in y]
    number = {(i, j): i * (ny + 1) + j for i in range(nx + 1) for j in range(ny + 1)}
    triangles = []
    for i in range(nx):
        for j in range(ny):
            a, b, c, d = number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]
            triangles += [(a, b, c), (a, c, d)]
    # the frame, counter-clockwise from its lower left corner, with the edge node each cable ends at
    ring = [((-1.25, -0.75), None)] + [((x[i], -0.75), number[i, 0]) for i in range(nx + 1)]
    ring += [((1.25, -0.75), None)] + [((1.25, y[j]), number[nx, j]) for j in range(ny + 1)]
    ring += [((1.25, 0.75), None)] + [((x[i], 0.75), number[i, ny]) for i in range(nx, -1, -1)]
    ring += [((-1.25, 0.75), None)] + [((-1.25, y[j]), number[0, j]) for j in range(ny, -1, -1)]
    first = len(nodes)
    nodes += [point for point, _ in ring]
    cables = [(edge, first + k) for k, (_, edge) in enumerate(ring) if edge is not None]
    beams = [(first + k, first + (k + 1) % len(ring)) for k in range(len(ring))]
    return {
        "node_position": np.column_stack([np.array(nodes), np.zeros(len(nodes))]),
        "triangle": np.array(triangles),
        "cable": np.array(cables),
        "beam": np.array(beams),
    }


def wave(xy: np.ndarray, m: int, n: int) -> np.ndarray:
    """Shape with m x n half-waves on edges that move: each factor covers 0.8 of its half-waves."""

    def factor(s: np.ndarray, k: int) -> np.ndarray:
        phase = 0.8 * k * np.pi * s
        return np.cos(phase) if k % 2 else np.sin(phase)

    inside = (np.abs(xy[:, 0]) <= 1 + 1e-9) & (np.abs(xy[:, 1]) <= 0.5 + 1e-9)
    return np.where(inside, factor(xy[:, 0] / LENGTH, m) * factor(xy[:, 1] / WIDTH, n), 0.0)


def geometry_variables() -> dict[str, tuple]:
    mesh = antenna_mesh()
    dims = {"triangle": "corner", "cable": "end", "beam": "end"}
    variables = {name: ((name, last), mesh[name], {"units": "1"}) for name, last in dims.items()}
    position = (("node", "component"), mesh["node_position"], {"units": "m", "long_name": "position"})
    return {"node_position": position, **variables}


@pytest.fixture
def antenna_modes() -> xr.Dataset:
    xy = antenna_mesh()["node_position"][:, :2]
    shape = np.zeros((len(WAVES), len(xy), 3))
    for k, (m, n) in enumerate(WAVES):
        shape[k, :, 2] = 2.5 * wave(xy, m, n)
    unit = {"units": "1"}
    return xr.Dataset(
        {
            "frequency": ("mode", FREQUENCIES, {"units": "Hz", "long_name": "natural frequency"}),
            "shape": (("mode", "node", "component"), shape, {"units": "kg^-1/2", "long_name": "mode shape"}),
            "label_m": ("mode", [m for m, _ in WAVES], unit),
            "label_n": ("mode", [n for _, n in WAVES], unit),
            "symmetry": ("mode", ["SA"[1 - m % 2] + "SA"[1 - n % 2] for m, n in WAVES], unit),
            **geometry_variables(),
        },
        {"mode": np.arange(1, len(WAVES) + 1), "component": ["x", "y", "z"]},
    )


@pytest.fixture
def antenna_run() -> xr.Dataset:
    """Stop from pi/5 rad/s in 1 s; w is the (1,2) shape times decaying steps of 2 Hz about an offset."""
    time = np.arange(10001) * 1e-3
    decay, pulse = 0.1, 4 * np.pi

    def step(t: np.ndarray) -> np.ndarray:
        return np.where(t > 0, 1 - np.exp(-decay * np.abs(t)) * np.cos(pulse * t), 0.0)

    motion = 0.24e-3 * (step(time) - 0.6 * step(time - 1.0) - 0.4 * step(time - 1.2))
    rate = np.pi / 5 * np.clip(1 - time, 0, None)
    xy = antenna_mesh()["node_position"][:, :2]
    every = np.array([0, 40, 150, 500, 600, 800, 1000, 1200, 1400, 1550, 1850, 2000])
    probes = {"A": np.array([[0.7036, 0.4267]]), "B": np.array([[0.0, 0.25]])}
    local = np.array([wave(point, 1, 2)[0] for point in probes.values()])
    field = np.zeros((every.size, len(xy), 3))
    field[:, :, 2] = motion[every, None] * wave(xy, 1, 2)
    zero = np.zeros(time.size)
    metre = {"units": "m", "long_name": "transverse displacement"}
    return xr.Dataset(
        {
            "w": (("time", "probe"), motion[:, None] * local, metre),
            "angular_velocity": (
                ("time", "component"),
                np.column_stack([rate, zero, zero]),
                {"units": "rad/s", "long_name": "angular velocity"},
            ),
            "displacement": (
                ("field_time", "node", "component"),
                field,
                {"units": "m", "long_name": "elastic displacement"},
            ),
            **geometry_variables(),
        },
        {
            "time": ("time", time, {"units": "s", "long_name": "time"}),
            "field_time": ("field_time", time[every], {"units": "s", "long_name": "time of field"}),
            "probe": list(probes),
            "component": ["x", "y", "z"],
        },
        {"title": "M2 stop", "status": "completed", "time_step": 1e-3},
    )
