"""Control steps per second of plants of reduced models, and milliseconds of one of the full structure.

Run ``python benchmarks/control_steps.py`` (``make benchmark-control``). The antenna M2 on 20 x 10 cells, a hub that
turns about x, a wheel and tensions x and y that change in every interval of 10 ms, seven noisy readings; 8 and 17
coordinates, steps of 5 ms by central differences. A call per step, one plant and 64 side by side; a table of 500
commands at a time; the full structure by generalized-alpha. Then ``tautflex/Slew-v0`` and ``tautflex/Stop-v0``, alone
and 64 side by side, and the functional twin of the slew with 128 runs of 50 steps. Processor times, medians of five;
what is left out is not installed.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from importlib.util import find_spec
from itertools import product
from typing import Any

import numpy as np
from step_cost import antenna
from threadpoolctl import threadpool_limits

import tautflex as tf

PULL = {axis: tf.TensionGroup(axis, command="tension") for axis in "xy"}
ACTUATORS = {"torque": tf.HubTorque("x", limit=5.0), **{name: tf.Actuator(each) for name, each in PULL.items()}}
POINTS = [[0.7, 0.4], [-0.7, 0.4], [0.7, -0.4], [0.9, 0.0]]
SENSORS = {
    "attitude": tf.Attitude(noise=1e-5),
    "rate": tf.Rate(noise=1e-5),
    "film": tf.Displacement(POINTS, noise=1e-6),
    "rms": tf.SurfaceRms(),
}
ASKED: dict[str, Any] = {"interval": 0.01, "damping": tf.Rayleigh(1e-3, 1e-3)}
HUB = tf.FreeHub(20.0, (5.0, 5.0, 8.0), axes="x")
BASES = {8: tf.ModalBasis(("rx",), count=7, candidates=60), 17: tf.ModalBasis(("rx",), count=16, candidates=130)}


def rate(once: Callable[[], int], repeats: int = 5) -> float:
    """Control steps per second of a function that returns how many it took; median, one call before them compiles."""
    once()
    rates = []
    for _ in range(repeats):
        began = time.process_time()
        rates.append(once() / (time.process_time() - began))
    return float(np.median(rates))


def commands(count: int) -> Any:
    """Torques [N m] and tensions [N]."""
    return np.random.default_rng(1).uniform(-1.0, 1.0, (count, 3)) * [0.2, 0.02, 0.02]


def compiled(rom: tf.ReducedModel, count: int) -> float:
    """Rate of one call per step."""
    plants, table = tf.CompiledPlant(rom, HUB, ACTUATORS, SENSORS, count=count, **ASKED), commands(500)
    table = table if count == 1 else np.repeat(table[:, None], count, axis=1)

    def once() -> int:
        plants.reset()
        for row in table:
            plants.step(row)
        return len(table) * count

    return rate(once)


def tabled(rom: tf.ReducedModel) -> float:
    """Rate of a table of commands."""
    plants, table = tf.CompiledPlant(rom, HUB, ACTUATORS, SENSORS, **ASKED), commands(500)
    return rate(lambda: len(plants.run(table)[1]))


def recorded(state: Any, table: Any) -> float:
    """Rate of a plant that keeps a record, under commands in turn."""
    plant = tf.Plant(state, HUB, ACTUATORS, SENSORS, **ASKED)

    def once() -> int:
        plant.reset()
        for row in table:
            plant.step(row)
        return len(table)

    return rate(once, 3)


def environment(task: str, coordinates: int) -> float:
    """Rate of an environment."""
    from tautflex.learning.environments.env import AntennaEnv

    env = AntennaEnv(task, coordinates=coordinates)
    actions = np.tile(commands(500)[:, :1], len(env.arena.limits))

    def once() -> int:
        env.reset(seed=0)
        for row in actions:
            env.step(row)
        return len(actions)

    return rate(once)


def environments(task: str, coordinates: int, count: int = 64) -> float:
    """Rate of as many side by side, without their resets."""
    from tautflex.learning.environments.vector import VectorAntennaEnv

    envs = VectorAntennaEnv(count, task, coordinates=coordinates)
    actions = np.repeat(np.tile(commands(150)[:, None, :1], len(envs.arena.limits)), count, axis=1)
    envs.reset(seed=0)

    def once() -> int:
        for row in actions:
            envs.step(row)
        return len(actions) * count

    return rate(once)


def twin(precision: str, runs: int = 128, steps: int = 50) -> tuple[float, float]:
    """Rates of the functional twin, forward and with the slope of a small policy."""
    import jax

    from tautflex.learning.functional import FunctionalTwin
    from tautflex.learning.rollout import Rollouts, start_layers

    made = FunctionalTwin(precision=precision)
    key, features = jax.random.PRNGKey(0), made.arena.observation.matrix.shape[1]
    rollouts = Rollouts(made, np.zeros((made.commands, features)), keep=0.7)
    params = made.draw(key, runs)
    layers = start_layers(key, (made.observed, 32, 32, made.commands), made.kind)
    course, keys = rollouts.begin(key, params), jax.random.split(key, steps)
    action = np.full((made.commands, runs), 0.01)
    held = jax.jit(lambda state: jax.lax.scan(lambda s, k: (made.step(k, s, action, params)[0], 0), state, keys)[0])
    slope = jax.jit(lambda weights: rollouts.slope(weights, key, course, params, steps)[1])

    def once(function: Callable[[Any], Any], start: Any) -> Callable[[], int]:
        return lambda: (jax.block_until_ready(function(start)), runs * steps)[1]

    return rate(once(held, course.state)), rate(once(slope, layers))


def main() -> None:
    """Print a table."""
    state = tf.equip(tf.solve_prestress(antenna("M2", (20, 10))), list(PULL.values()))
    print("| plant | control steps per second |\n|---|---|")
    for count, basis in BASES.items():
        rom = tf.reduce(state, basis)
        print(f"| {rom.size} coordinates, one call per step | {compiled(rom, 1):.0f} |", flush=True)
        print(f"| {rom.size} coordinates, 64 plants per call | {compiled(rom, 64):.0f} |", flush=True)
        print(f"| {rom.size} coordinates, 500 steps per call | {tabled(rom):.0f} |", flush=True)
        print(f"| {rom.size} coordinates, `Plant` with its record | {recorded(rom, commands(100)):.0f} |", flush=True)
        assert rom.size == count
    for task, count in product(("slew", "stop"), BASES):
        name = f"{count} coordinates, `tautflex/{task.capitalize()}-v0`"
        print(f"| {name} | {environment(task, count):.0f} |", flush=True)
        print(f"| {name}, 64 side by side | {environments(task, count):.0f} |", flush=True)
    for precision in ("double", "single") if find_spec("jax") else ():
        forward, slope = twin(precision)
        print(f"| 8 coordinates, functional twin, {precision} | {forward:.0f} |", flush=True)
        print(f"| 8 coordinates, functional twin with the slope of a policy, {precision} | {slope:.0f} |", flush=True)
    table = commands(50)
    for said, given in (
        ("all commands change", table),
        ("the torque changes", table * [1.0, 0.0, 0.0]),
        ("all stay", np.repeat(table[:1], 50, axis=0)),
    ):
        steps = recorded(state, given)
        print(f"| full structure, `Plant`, {said} | {steps:.0f}, {500.0 / steps:.2f} ms per time step |", flush=True)


if __name__ == "__main__":
    with threadpool_limits(1):  # a second thread of the BLAS that only waits would count as work
        main()
