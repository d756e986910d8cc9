"""Small linear plants with known answers, and loops with them."""

from __future__ import annotations

import numpy as np

from tautflex.control.linear import LinearPlant
from tautflex.control.signals import Channel, LoopSpec, Reference

_UNITS = {"attitude": "rad", "rate": "rad/s", "torque": "N m"}


def modal_plant(
    frequencies, ratios, pushes, looks, *, through=0.0, bilinear=None, axes=0, inertia=None, velocities=False
) -> LinearPlant:
    """Modes [Hz] with damping ratios, forces per input (mode, input) and rows (output, mode), perhaps on a hub.

    A hub has the given inertia [kg m^2], an input of torque in front of the others, and outputs of attitude and rate.
    """
    w, z = 2.0 * np.pi * np.asarray(frequencies, dtype=float), np.asarray(ratios, dtype=float)
    pushes, looks = np.atleast_2d(np.asarray(pushes, float)), np.atleast_2d(np.asarray(looks, float))
    r, h = len(w), axes
    mass, stiffness, damping = np.eye(h + r), np.zeros((h + r, h + r)), np.zeros((h + r, h + r))
    stiffness[h:, h:], damping[h:, h:] = np.diag(w**2), np.diag(2.0 * z * w)
    forces, rows = np.zeros((h + r, h + pushes.shape[1])), np.zeros((len(looks), 2 * (h + r)))
    forces[h:, h:], rows[:, h : h + r] = pushes, looks
    if velocities:
        rows = np.concatenate([rows, np.roll(rows, h + r, axis=1)])
    labels = [f"u{k}" for k in range(pushes.shape[1])]
    outputs = [f"y{k}" for k in range(len(rows))]
    if h:
        mass[0, 0], mass[0, 1:] = inertia, 0.3
        mass[1:, 0], forces[0, 0] = 0.3, 1.0
        hub = np.zeros((2, 2 * (h + r)))
        hub[0, 0] = hub[1, h + r] = 1.0
        rows, outputs, labels = np.concatenate([hub, rows]), ["attitude", "rate", *outputs], ["torque", *labels]
    n, m = h + r, forces.shape[1]
    inverse = np.linalg.inv(mass)
    positions = [*(["theta_x"] * h), *(f"eta{k + 1}" for k in range(r))]
    return LinearPlant(
        np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ damping]]),
        np.concatenate([np.zeros((n, m)), inverse @ forces]),
        rows,
        np.full((len(rows), m), through),
        (*positions, *(f"d_{name}" for name in positions)),
        tuple(labels),
        tuple(outputs),
        ("N",) * m,
        ("m",) * len(rows),
        h,
        np.diag(w**2),
        np.zeros((m, r, r)) if bilinear is None else np.asarray(bilinear, dtype=float),
        np.zeros(len(rows)),
    )


def spec_of(plant: LinearPlant, interval: float, noise: float = 0.0) -> LoopSpec:
    """Loop with one channel for every number of a plant."""
    seen = tuple(Channel(label, _UNITS.get(label.partition("[")[0], "m"), 1, noise) for label in plant.outputs)
    told = tuple(Channel(label, _UNITS.get(label.partition("[")[0], "N")) for label in plant.inputs)
    return LoopSpec(seen, told, interval, plant.axes, plant)


def radius(matrix: np.ndarray) -> float:
    """Largest size of an eigenvalue."""
    return float(np.abs(np.linalg.eigvals(matrix)).max())


def run_bilinear(plant: LinearPlant, law, start, interval, count, reference=None):
    """States of a loop whose commands also change the stiffness: exact for held commands (Taylor series)."""
    spec = spec_of(plant, interval)
    memory, x, last, states, commands = law.start(spec), np.array(start, float), np.zeros(len(plant.inputs)), [], []
    half, eta = len(x) // 2, plant.positions
    for step in range(count):
        states.append(x)
        wanted = Reference.rest(step * interval, plant.axes) if reference is None else reference(step * interval)
        memory, last = law.act(memory, plant.C @ x + plant.D @ last, wanted)
        commands.append(last)
        a = plant.A.copy()
        a[np.ix_(eta + half, eta)] -= np.tensordot(last, plant.bilinear, 1)
        term, x = x, x.copy()
        for order in range(1, 16):
            term = interval / order * (a @ term + (plant.B @ last if order == 1 else 0.0))
            x += term
    return np.array(states), np.array(commands)
