"""Environments keep the promises of Gymnasium, and those of the tasks."""

from __future__ import annotations

import resource
from pathlib import Path

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

import tautflex as tf  # noqa: E402
import tautflex.learning  # noqa: E402  (registers)
from tautflex.learning.environments import loops  # noqa: E402
from tautflex.learning.environments.bodies import CompiledBodies, PlantBodies  # noqa: E402
from tautflex.learning.environments.env import AntennaEnv  # noqa: E402
from tautflex.learning.environments.vector import VectorAntennaEnv  # noqa: E402
from unit.learning_cases import coarse  # noqa: E402

pytestmark = pytest.mark.slow  # compiles plants


@pytest.fixture(scope="module")
def env():
    return AntennaEnv("slew", case=coarse("slew"))


@pytest.mark.parametrize(
    ("task", "plant"), [("slew", "reduced"), ("hold", "reduced"), ("stop", "reduced"), ("stop", "full")]
)
@pytest.mark.filterwarnings("ignore::UserWarning")  # what the checker says about windows and specs
def test_gymnasium_has_nothing_to_say(task, plant):
    made = gymnasium.make(f"tautflex/{task.capitalize()}-v0", case=coarse(task), plant=plant, render_mode="rgb_array")
    check_env(made.unwrapped)
    made.reset(seed=0)
    picture = made.render()
    assert picture.ndim == 3
    assert picture.dtype == np.uint8
    assert len(np.unique(picture)) > 10


def episode(env, seed, actions):
    seen, info = env.reset(seed=seed)
    rows = [[*seen]]
    for action in actions:
        seen, reward, terminated, truncated, _ = env.step(action)
        rows.append([*seen, reward, terminated, truncated])
        if terminated or truncated:
            break
    return info, rows


def test_same_seed_same_bits_and_time_alone_truncates(env):
    actions = np.random.default_rng(1).uniform(-0.1, 0.1, (40, 3))
    first, second = episode(env, 5, actions), episode(env, 5, actions)
    assert first == second
    assert len(first[1]) == 31
    assert first[1][-1][-2:] == [False, True]
    assert episode(env, 6, actions)[0] != first[0]
    with pytest.raises(tf.InputError, match="call reset first"):
        env.step(actions[0])


@pytest.mark.parametrize(("task", "plant"), [("slew", "reduced"), ("slew", "full"), ("stop", "reduced")])
def test_rows_are_single_environments(task, plant):
    """Row i with seed s goes as a single environment with seed s + i, beyond the end of episodes too."""
    case, random = coarse(task, 0.1), np.random.default_rng(3)
    many = VectorAntennaEnv(3, task, case=case, plant=plant)
    seen, _ = many.reset(seed=7)
    single = [AntennaEnv(task, case=case, plant=plant) for _ in range(3)]
    for row, one in enumerate(single):
        assert np.array_equal(one.reset(seed=7 + row)[0], seen[row])
    for number in range(14):
        actions = random.uniform(-1.0, 1.0, many.action_space.shape)
        seen, reward, terminated, truncated, info = many.step(actions)
        for row, one in enumerate(single):
            if number == 10:  # the step behind the last one begins the next episode
                assert np.array_equal(one.reset()[0], seen[row])
                assert (reward[row], terminated[row], truncated[row]) == (0.0, False, False)
                assert info[f"_{many.arena.task.drawn[0]}"][row]
                continue
            own = one.step(actions[row])
            assert np.allclose(own[0], seen[row], rtol=1e-13, atol=1e-13)
            assert np.isclose(own[1], reward[row], rtol=1e-12)
            assert own[2:4] == (terminated[row], truncated[row])
            assert np.isclose(own[4]["cost"], info["cost"][row], rtol=1e-12)


def test_modes_of_the_vector_environment():
    case = coarse("slew", 0.05)
    same = gymnasium.make_vec("tautflex/Slew-v0", num_envs=2, case=case, autoreset_mode="SameStep")
    stopping = VectorAntennaEnv(2, case=case, autoreset_mode="DISABLED")
    next_step = VectorAntennaEnv(2, case=case)
    for one in (same, stopping, next_step):
        one.reset(seed=0)
    for _ in range(5):
        got = [one.step(np.zeros((2, 3))) for one in (same, stopping, next_step)]
    assert got[0][3].all()
    for row in range(2):
        assert np.array_equal(got[0][4]["final_obs"][row], got[1][0][row])
    begun, _ = next_step.step(np.zeros((2, 3)))[:2]
    assert np.array_equal(got[0][0], begun)  # what the same step sees, the next one does
    with pytest.raises(tf.InputError, match="reset_mask"):
        stopping.step(np.zeros((2, 3)))
    with pytest.raises(tf.InputError, match=r"action: expected shape \(2, 3\), got \(3,\)"):
        same.unwrapped.step(np.zeros(3))
    assert np.array_equal(same.reset(seed=np.int64(4))[0], same.reset(seed=[4, 5])[0])
    for wrong in (0.5, "x", [1, "x"], [1, 2, 3], -1):
        with pytest.raises(tf.InputError, match="seed: expected"):
            same.reset(seed=wrong)
    with pytest.raises(tf.InputError, match="options: expected a mapping, or None, got 'x'"):
        same.reset(options="x")
    for mode in ("Never", 3):
        with pytest.raises(tf.InputError, match=f"autoreset_mode: expected one of .*, got {mode!r}"):
            VectorAntennaEnv(2, case=case, autoreset_mode=mode)
    kept = got[1][0][1]
    seen, _ = stopping.reset(options={"reset_mask": np.array([True, False])})
    assert np.array_equal(seen[1], kept)
    assert not np.array_equal(seen[0], got[1][0][0])


def test_a_stop_is_one_array_program(monkeypatch):
    """Observations and rewards of a plant with its record through the end of a stop; spins of rows are their own."""
    case = coarse("stop", 0.3, task={"duration": 0.3, "stop_duration": 0.2, "rate_range": [0.05, 0.07]})
    fast = AntennaEnv("stop", case=case)
    assert isinstance(fast._loops.bodies, CompiledBodies)
    with monkeypatch.context() as patched:
        patched.setattr(loops, "bodies_of", PlantBodies)
        kept = AntennaEnv("stop", case=case)
    for seed in (0, 1):
        assert np.allclose(fast.reset(seed=seed)[0], kept.reset(seed=seed)[0], rtol=0.0, atol=1e-12)
        for action in np.random.default_rng(seed).uniform(-1.0, 1.0, (30, 2)):
            one, other = fast.step(action), kept.step(action)
            assert np.allclose(one[0], other[0], rtol=0.0, atol=1e-11)
            assert one[1] == pytest.approx(other[1], abs=1e-11)
            assert one[2:4] == other[2:4]
        assert one[3]
    same = gymnasium.make_vec("tautflex/Stop-v0", num_envs=2, case=case, autoreset_mode="SameStep")
    first, info = same.reset(seed=4)
    assert info["rate"][0] != info["rate"][1]
    for _ in range(30):
        last = same.step(np.zeros((2, 2)))
    assert last[3].all()
    assert not np.array_equal(last[4]["final_obs"][0], last[0][0])
    assert np.array_equal(same.reset(seed=4)[0], first)


@pytest.mark.parametrize("given", [{"axis": [1.0, 1.0, 0.0]}, {"stop_duration": 0.2005}])
def test_motions_that_no_array_program_takes_are_plants(given):
    """About an axis between those of the hub, or with a jump within a step of 5 ms."""
    case = coarse("stop", 0.3, task={"duration": 0.3, **given})
    env = AntennaEnv("stop", case=case)
    assert isinstance(env._loops.bodies, PlantBodies)
    env.reset(seed=0)
    assert np.isfinite(env.step(np.zeros(2))[1])


def test_reduced_and_full_plants_agree():
    """Half a second of a turn: attitude to the discretization in time, the film as the reduction has it."""
    case = coarse("slew", 0.5)
    quiet = {"angle": 0.4, "tension_error": 0.03, "effectiveness": 0.9, "noise": 0.0}
    envs = [AntennaEnv("slew", case=case, plant=plant) for plant in ("reduced", "full")]
    for one in envs:
        one.reset(seed=0, options=quiet)
    for number in range(50):
        told = [one.step([0.3 if number < 25 else -0.3, 0.5, -0.5])[4] for one in envs]
    assert told[0]["attitude_error"] == pytest.approx(told[1]["attitude_error"], rel=1e-5)
    assert told[0]["surface_rms"] == pytest.approx(told[1]["surface_rms"], rel=0.02)


STATUS = Path("/proc/self/statm")


@pytest.mark.skipif(not STATUS.exists(), reason="memory of a process is read from /proc")
@pytest.mark.parametrize("many", [False, True])
def test_random_steps_give_numbers_and_leave_no_memory_behind(many):
    """10 000 steps of episodes of 0.2 s, alone and side by side, so 500 resets."""
    case = coarse("hold", 0.2)
    made = VectorAntennaEnv(20, "hold", case=case) if many else AntennaEnv("hold", case=case)
    made.action_space.seed(0)
    made.reset(seed=0)

    def steps(count):
        for _ in range(count // (20 if many else 1)):
            seen, reward, terminated, truncated, _ = made.step(made.action_space.sample())
            assert np.isfinite(seen).all()
            assert np.isfinite(reward).all()
            if not many and (terminated or truncated):
                made.reset()
        return int(STATUS.read_text().split()[1]) * resource.getpagesize()

    assert steps(2_000) + 2**19 > steps(8_000)  # a few kilobytes kept by each reset would be seen


def test_a_crash_never_pays():
    """An episode that ends early is worth less than any that goes on, whatever was earned before."""
    case = coarse("slew", 0.3, task={"duration": 0.3, "attitude_limit": 0.21})
    env = AntennaEnv("slew", case=case)
    env.reset(seed=0, options={"angle": 0.2})
    rewards = []
    while True:
        _, reward, terminated, truncated, _ = env.step([-1.0, 0.0, 0.0])
        rewards.append(reward)
        if terminated or truncated:
            break
    assert terminated
    worst = env.arena.task.worst_reward(3)
    assert rewards[-1] == pytest.approx(worst * (30 - len(rewards) + 1))
    assert min(rewards[:-1]) >= worst


def test_options_are_parameters(env):
    _, info = env.reset(seed=0, options={"angle": 0.33, "noise": 0.0})
    assert (info["angle"], info["noise"]) == (0.33, 0.0)
    _, other = env.reset(seed=0)
    assert {**other, "angle": 0.33, "noise": 0.0} == info  # the others are drawn as without options
    with pytest.raises(tf.InputError, match=r"options: expected parameters among angle, .*got 'angel'"):
        env.reset(options={"angel": 0.3})
    with pytest.raises(tf.InputError, match=r"options\.angle"):
        env.reset(options={"angle": 30.0})
    env.reset(seed=0)
    with pytest.raises(tf.InputError, match="action: expected finite numbers"):
        env.step([np.nan, 0.0, 0.0])
    with pytest.raises(tf.InputError, match=r"options: expected a mapping, or None, got 3"):
        env.reset(options=3)
    env.reset(seed=0)
    for action in ([0.1, 0.2, "x"], [[0.1], 0.2, 0.3]):
        with pytest.raises(tf.InputError, match="action: expected an array of numbers"):
            env.step(action)
    for action in (0.3, [0.3]):  # which would be broadcast
        with pytest.raises(tf.InputError, match=r"action: expected shape \(3,\), got \("):
            env.step(action)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"plant": "half"}, "plant: expected one of 'reduced', 'full', got 'half'"),
        ({"render_mode": "ansi"}, "render_mode"),
        ({"case": coarse("slew", task={"commands": ["wheel"]})}, "task.commands: expected names of actuators"),
        ({"actuators": {"torque": tf.HubTorque("x")}}, "actuators.torque.limit: missing"),
        ({"sensors": 3}, "sensors: expected a mapping such as {'rate': Rate()}, got 3"),
        ({"sensors": {"film": 3}}, "sensors.film: expected a sensor such as Rate(), got 3"),
    ],
)
def test_wrong_arguments_are_told_in_one_line(given, words):
    with pytest.raises(tf.InputError) as caught:
        AntennaEnv("slew", **{"case": coarse("slew"), **given})
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_without_a_display_frames_go_to_a_file(monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    env = AntennaEnv("slew", case=coarse("slew", 0.1), render_mode="human")
    env.reset(seed=0)
    for _ in range(3):
        env.step(np.zeros(3))
    with pytest.warns(UserWarning, match="no display here") as told:
        env.step(np.zeros(3))
    env.close()
    assert len(told) == 1
    from PIL import Image

    with Image.open(str(told[0].message).rpartition(" ")[2]) as film:
        assert film.size == (480, 360)


@pytest.mark.parametrize("task", [tf.SlewTask(), tf.StopTask(), tf.HoldTask()], ids=lambda task: task.kind)
def test_no_reward_is_below_the_worst(task):
    random = np.random.default_rng(0)
    angle, rms = random.uniform(0.0, task.attitude_limit, 500), random.uniform(0.0, task.surface_limit, 500)
    command, before = random.choice([-1.0, 1.0], (2, 500, 3))
    rewards = task.reward(angle, rms, command, before)
    assert (rewards >= task.worst_reward(3)).all()
    assert (rewards <= 0.0).all()
    assert task.reward(0.0, 0.0, np.zeros(3), np.zeros(3)) == 0.0
    assert not task.failed(task.attitude_limit, task.surface_limit)
    assert task.failed(np.nan, 0.0)
    assert task.failed(0.0, 1.01 * task.surface_limit)
