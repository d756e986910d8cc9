"""The functional twin against the compiled plant, its slope against differences, and training that goes on."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from dataclasses import replace
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import tautflex as tf
from tautflex.cli import main
from tautflex.learning.arena import Arena
from tautflex.learning.cases import task_case
from tautflex.learning.environments.env import AntennaEnv
from tautflex.learning.environments.references import reference_table
from tautflex.learning.functional import FunctionalTwin
from tautflex.learning.gain import linear_gain
from tautflex.learning.rollout import Rollouts, start_layers
from tautflex.learning.train import train

pytestmark = [pytest.mark.jax, pytest.mark.slow]
RUNS, STEPS = 3, 30


@cache
def case():
    """The registered task on a coarser film, half a second long, with drives that have all they can have."""
    actuators = task_case("slew").model_dump(by_alias=True, exclude_none=True)["actuators"]
    actuators["torque"] |= {"rate": 200.0, "lag": 0.02}
    actuators["tension_x"] |= {"lag": 0.01, "resolution": 1e-6}
    actuators["tension_y"] |= {"delay": 0.02}
    return task_case("slew").replaced(
        mesh={"divisions": [8, 4]},
        cables={"per_long_edge": 9, "per_short_edge": 5},
        task={"duration": 0.5, "coordinates": 4},
        actuators=actuators,
    )


@cache
def arena():
    return Arena(case())


@cache
def twin():
    return FunctionalTwin(arena())


@cache
def compiled():
    """Reset and step of three runs, the run last."""
    return jax.jit(twin().reset), jax.jit(twin().step)


def parameters(**more):
    given = {
        "angle": [0.3, 0.45, 0.6], "tension_error": [0.05, 0.0, -0.08], "effectiveness": [0.8, 1.0, 1.1],
        "noise": np.zeros(RUNS), "stiffness": np.ones(RUNS), "damping": np.ones(RUNS), "delay": np.zeros(RUNS),
    }  # fmt: skip
    return {name: jnp.asarray(value) for name, value in (given | more).items()}


def test_twin_is_the_compiled_plant(verification_row):
    """Drives with rate, lag, delay and steps; readings and the film's rms."""
    own, params = arena(), parameters()
    exact = {name: replace(sensor, noise=0.0) for name, sensor in own.sensors.items()} | {"rms": tf.SurfaceRms()}
    drives = {**own.actuators, **own.disturbances}
    plants = tf.CompiledPlant(
        own.reduced, own.hub, drives, exact, interval=own.interval, time_step=5e-3, damping=own.damping, count=RUNS
    )
    plants.reset(0)
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (STEPS, len(own.limits), RUNS))
    gain = own.limits * (1.0 + (np.asarray(params["effectiveness"])[:, None] - 1.0) * own.on_structure)
    errors = np.asarray(params["tension_error"])[:, None] * own.tension_units
    reset, step = compiled()
    state, _ = reset(jax.random.key(0), params)
    worst, largest = 0.0, 0.0
    for action in actions:
        state, _, _, ended, _, info = step(jax.random.key(0), state, action, params)
        expected = plants.step(np.concatenate([gain * action.T, errors], axis=1))
        got = np.concatenate([np.asarray(state.measured).T, np.asarray(info["surface_rms"])[:, None]], axis=1)
        largest = np.maximum(largest, np.abs(expected).max(axis=0))
        worst = max(worst, float((np.abs(got - expected) / largest).max()))
        assert not ended.any()
    assert worst < 1e-9
    verification_row("functional twin, 3 runs of 30 intervals: readings", 0, worst, "compiled plant")


def short(name):
    """A registered task on a coarser film, half a second long."""
    return task_case(name).replaced(
        mesh={"divisions": [8, 4]},
        cables={"per_long_edge": 9, "per_short_edge": 5},
        task={"duration": 0.5, "coordinates": 4} | ({"stop_duration": 0.2} if name == "stop" else {}),
    )


EPISODES = {
    # Strikes, a snap of the temperature, an error of the tension.
    "hold": {"first_time": 0.034, "second_time": 0.12, "snap_time": 0.2, "snap": 1.5, "first": 2e-3, "second": -1e-3},
    # A spin that stops behind twenty of thirty intervals.
    "stop": {"rate": 0.6},
}


@pytest.mark.parametrize("name", EPISODES)
def test_twin_of_a_task_is_its_environment(name, verification_row):
    """Observations and rewards of one episode."""
    env, twin = AntennaEnv(name, case=short(name)), FunctionalTwin(short(name))
    given = EPISODES[name] | {"tension_error": 0.05, "effectiveness": 0.9, "noise": 0.0}
    seen, _ = env.reset(seed=0, options=given)
    key, step = jax.random.key(0), jax.jit(twin.step)
    state, told = twin.reset(key, given)
    worst, moved = float(np.abs(told - seen).max()), 0.0
    for action in np.random.default_rng(0).uniform(-0.1, 0.1, (STEPS, twin.commands)):
        seen, reward, *_, info = env.step(action)
        state, told, paid, _, _, also = step(key, state, action, given)
        worst = max(worst, float(np.abs(told - seen).max()), abs(float(paid) - reward))
        assert float(also["surface_rms"]) == pytest.approx(info["surface_rms"], rel=1e-9)
        moved = max(moved, info["surface_rms"])
    assert moved > 1e-5
    assert worst < 1e-9
    verification_row(f"functional twin of a {name}, 30 intervals: observations and rewards", 0, worst, "environment")


def test_one_run_many_and_vmap_are_the_same():
    params, action = parameters(), jnp.full((3, RUNS), 0.3)
    key = jax.random.key(3)
    reset, step = compiled()
    state, seen = reset(key, params)
    many = step(key, state, action, params)
    keys = jnp.stack([key] * RUNS)

    def alone(key, action, params):
        return twin().step(key, twin().reset(key, params)[0], action, params)

    mapped = jax.jit(jax.vmap(alone))(keys, action.T, params)
    np.testing.assert_allclose(mapped[1].T, many[1], atol=1e-12)
    np.testing.assert_allclose(mapped[2], many[2], rtol=1e-12)
    assert seen.shape == (arena().observation.size, RUNS)
    assert float(jnp.abs(seen).max()) <= 1.0


def test_reference_and_observation_are_those_of_the_environment():
    own, params = arena(), parameters()
    times = own.interval * np.arange(own.steps + 1)
    for run in range(RUNS):
        expected = reference_table(own.task.maneuver({"angle": float(params["angle"][run])}), times, own.hub)
        got = twin().reference(jnp.asarray(times), {"angle": params["angle"][run]})
        np.testing.assert_allclose(got.T, expected, atol=1e-12)
    state, seen = compiled()[0](jax.random.key(0), params)
    features = np.asarray(twin().features(state, state.measured, state.measured, params))
    for run in range(RUNS):
        np.testing.assert_allclose(
            seen[:, run], own.observation(features[:, run], np.zeros(3), np.float64(0.0)), atol=1e-12
        )


def test_single_precision_says_how_exact_it_is(verification_row):
    params, coarse = parameters(), FunctionalTwin(arena(), "single")
    ends = []
    for each in (twin(), coarse):
        reset, step = compiled() if each is twin() else (jax.jit(each.reset), jax.jit(each.step))
        state, _ = reset(jax.random.key(0), params)
        for _ in range(STEPS):
            state, *_ = step(jax.random.key(0), state, jnp.full((3, RUNS), 0.2), params)
        ends.append(np.asarray(state.motion.q, dtype=float))
        assert state.motion.q.dtype == each.kind
    error = float(np.abs(ends[1] - ends[0]).max() / np.abs(ends[0]).max())
    assert error < 1e-3
    verification_row("functional twin, 30 intervals in single precision: coordinates", 0, error, "double precision")


def test_slope_of_a_policy_is_that_of_differences(verification_row):
    rollouts = Rollouts(twin(), linear_gain("pd", arena()), 0.7)
    params = parameters()
    course = jax.jit(rollouts.begin)(jax.random.key(0), params)
    layers = start_layers(jax.random.key(1), [twin().observed, 4, 3], jnp.float64)
    key = jax.random.key(2)
    slope = jax.jit(lambda layers: rollouts.slope(layers, key, course, params, 10)[1])(layers)
    value = jax.jit(lambda layers: jnp.mean(rollouts.run(layers, key, course, params, 10)[1][0]))
    way = jax.tree.map(lambda part: jnp.cos(jnp.arange(part.size, dtype=float)).reshape(part.shape), layers)
    step = 1e-5
    ends = [float(value(jax.tree.map(lambda a, b, s=s: a + s * step * b, layers, way))) for s in (1.0, -1.0)]
    expected = (ends[0] - ends[1]) / (2.0 * step)
    got = float(sum(jnp.vdot(a, b) for a, b in zip(jax.tree.leaves(slope), jax.tree.leaves(way), strict=True)))
    assert got == pytest.approx(expected, rel=1e-5)
    verification_row("slope of the reward after a policy", expected, got, "differences")


def test_training_that_is_killed_goes_on_to_the_same_policy(tmp_path):
    asked = {"case": case(), "runs": 4, "judged": 2, "horizon": 10, "judge_every": 2, "layers": (4,), "seed": 5}
    whole = train(iterations=6, **asked)
    place = tmp_path / "training.npz"
    # A process of its own is killed as soon as it has kept its first two iterations.
    (tmp_path / "slew.toml").write_text(case().to_toml(), encoding="utf-8")
    given = {**asked, "case": str(tmp_path / "slew.toml"), "checkpoint": str(place)}
    code = (
        "import os, signal\nfrom tautflex.learning.train import train\n"
        f"train(iterations=6, progress=lambda part, words: os.kill(os.getpid(), signal.SIGKILL), **{given!r})"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == -signal.SIGKILL
    rest = train(iterations=6, checkpoint=place, **asked)
    assert rest.policy.digest == whole.policy.digest
    assert rest.costs[-1] == whole.costs[-1]
    assert whole.cost == min(whole.costs) <= whole.start_cost
    file = whole.policy.save(tmp_path / "policy.npz")
    assert tf.Policy.load(file).digest == whole.policy.digest
    with pytest.raises(tf.InputError, match=r"checkpoint: expected one of this training.*another \(other settings"):
        train(iterations=6, checkpoint=place, **{**asked, "seed": 6})
    place.write_bytes(place.read_bytes()[:100])
    with pytest.raises(tf.InputError, match="damaged file"):
        train(iterations=6, checkpoint=place, **asked)


def test_a_stop_is_trained():
    """Behind no law, as there is no hub; the policy flies the loop of its case."""
    asked = {"case": short("stop"), "runs": 2, "judged": 1, "horizon": 10, "judge_every": 1, "layers": (4,)}
    found = train("stop", iterations=2, **asked)
    assert (found.skipped, len(found.costs)) == (0, 3)
    assert found.cost == min(found.costs)
    law, spec = found.policy, Arena(short("stop")).spec
    assert not law.gain.any()
    command = law.act(law.start(spec), np.zeros(4), tf.Reference.rest(0.0, 0))[1]
    assert np.isfinite(command).all()


def test_a_policy_goes_from_one_command_to_the_next(tmp_path, capsys):
    """Trained, kept, and judged beside named laws."""
    file, place = tmp_path / "slew.toml", tmp_path / "training.npz"
    file.write_text(case().replaced(actuators=task_case("slew").actuators).to_toml(), encoding="utf-8")

    def told(*words):
        assert main([str(word) for word in (*words, "--json")]) == 0
        return json.loads(capsys.readouterr().out)

    policy = tmp_path / "p.npz"
    trained = told("train", file, "-o", policy, "--iterations", 2, "--seed", 3, "--checkpoint", place)
    assert tf.Policy.load(policy).digest == trained["digest"]
    assert (trained["iterations"], trained["skipped"]) == (2, 0)
    assert trained["cost"] == min(trained["curve"]["cost"]) <= trained["start_cost"]
    assert main(["train", str(file), "-o", str(policy), "--iterations", "2"]) == 2
    assert "p.npz: expected a new file" in capsys.readouterr().err

    words = ["--law", "pd", "--law", "zvd+lqg", "--policy", policy, "--budget", 2, "--angles", 1, "--seeds", 1]
    answer = told("evaluate", file, *words, "--workers", 1, "-o", tmp_path / "judged")
    assert set(answer["laws"]) == {"pd", "zvd+lqg", "p"}
    assert (answer["scenarios"], answer["failures"]) == (3, [])
    assert all(np.isfinite(each["cost"]) and abs(each["gap"]) < 1.0 for each in answer["laws"].values())
    assert len(list((tmp_path / "judged" / "episodes").glob("*.json"))) == 3 * 3 * 2


def test_the_horizon_is_a_part_of_the_episode():
    """The largest up to 250 where none is given, but not one that is far shorter."""
    with pytest.raises(
        tf.InputError, match=r"horizon: expected a whole part .* 509 intervals, got None.*horizon = 1, or"
    ):
        train(case=case().replaced(task={"duration": 5.09}))


def test_what_has_no_functional_form_is_refused():
    with pytest.raises(
        tf.UnsupportedError, match=r"task.stop_duration: .*got 20.5; set for example stop_duration = 0.2"
    ):
        FunctionalTwin(short("stop").replaced(task={"stop_duration": 0.205}))
    with pytest.raises(tf.UnsupportedError, match=r"hub: expected one .* and none for a stop"):
        FunctionalTwin(Arena(case(), tf.StopTask(commands=("tension_x",))))
    with pytest.raises(tf.InputError, match=r"horizon: expected a whole part .* 50 intervals, got 20.*horizon = 10"):
        train(case=case(), horizon=20)
    with pytest.raises(tf.InputError, match="law: expected a linear law without memory"):
        linear_gain(lambda time, y: 0.0 * y[:3] + 1.0, arena())
    with pytest.raises(tf.InputError, match=r"law: expected a linear law without memory.*'lqg'.*take 'pd'"):
        linear_gain("lqg", arena())
