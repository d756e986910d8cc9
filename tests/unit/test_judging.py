"""Laws and policies before the judge: the same loop as in training, paired episodes, files that go on."""

from __future__ import annotations

import json
import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import tautflex as tf
from tautflex import compiling
from tautflex.case import load_case
from tautflex.cli import main
from tautflex.control.loop import close_loop
from tautflex.control.tasks.observation import Observation
from tautflex.control.tasks.policy import SHIPPED
from tautflex.learning.arena import Arena
from tautflex.learning.cases import task_case
from tautflex.learning.environments.loops import Loops
from tautflex.learning.judging import evaluate as judging
from tautflex.learning.judging.baselines import baseline
from tautflex.learning.judging.evaluate import summary
from tautflex.learning.judging.scenarios import METRICS, Scenario, scenarios_of, start_on, tensioned
from tautflex.learning.judging.tune import numbers_of, with_numbers
from unit.learning_cases import coarse

QUIET = {"angle": 0.4, "tension_error": 0.0, "effectiveness": 1.0, "noise": 0.0}


@pytest.fixture(scope="module")
def arena():
    case = coarse("slew")
    silent = {name: {**sensor.model_dump(exclude_none=True), "noise": 0.0} for name, sensor in case.sensors.items()}
    return Arena(case.replaced(sensors=silent))


@pytest.fixture(scope="module")
def policy(arena):
    spec, random = arena.spec, np.random.default_rng(0)
    seen = Observation.of(spec, arena.task.duration)
    layers = tuple((0.5 * random.standard_normal((out, into)), np.zeros(out)) for into, out in ((seen.size, 8), (8, 3)))
    gain = 0.01 * random.standard_normal((3, seen.matrix.shape[1]))
    return tf.Policy(seen, layers, gain, arena.limits, spec.measured, spec.commanded, spec.interval, 0.7, {"seed": 0})


@pytest.mark.slow
def test_an_episode_that_ctrl_c_cut_short_is_not_kept(tmp_path):
    def law(time, measurement):
        if time > 0.02:
            signal.raise_signal(signal.SIGINT)
        return np.zeros(3)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    asked = {"scenarios": [Scenario(QUIET)], "plants": ["full"], "directory": tmp_path, "workers": 1}
    try:
        with pytest.raises(KeyboardInterrupt):
            tf.evaluate({"law": law}, coarse("slew", 0.1), **asked)
    finally:
        signal.signal(signal.SIGINT, before)
    assert not list(tmp_path.iterdir())


def test_a_policy_in_a_loop_does_what_it_does_in_an_episode(arena, policy):
    """Observation, network and plant of training against those of `close_loop`, over an episode of the full plant."""
    loops, task = Loops(arena, "full"), arena.task
    loops.reset(0, np.random.default_rng(0), QUIET)
    run = close_loop(arena.plant("full", exact=False), policy, task.maneuver(QUIET), task.duration)
    spec, measured = arena.spec, run.data["measurement"].values
    for number in range(arena.steps):
        z = np.concatenate(
            [measured[number], measured[max(number - 1, 0)], run.data["reference"].values[number].ravel(), [0.4]]
        )
        assert np.allclose(arena.observation(z, loops.actions[0], number * spec.interval), loops.seen[0], atol=1e-12)
        loops.actions[0] = run.data["command"].values[number] / arena.limits
        loops.step()
    assert np.allclose(loops.bodies.readings[0, : len(spec.measured)], measured[-1], rtol=1e-9, atol=1e-15)
    found = judging.play(arena, policy, tf.Scenario(QUIET), "full")
    assert np.isfinite(found["cost"])


def test_policies_come_back_from_their_files(arena, policy, tmp_path):
    file = policy.save(tmp_path / "p.npz")
    again = tf.Policy.load(file)
    assert again.digest == policy.digest
    assert again.told == {"seed": 0}
    law = tf.PolicyLaw(str(file))
    y = np.arange(6) * 1e-3
    reference = tf.Reference.rest(0.1, 1)
    assert np.array_equal(
        law.act(law.start(arena.spec), y, reference)[1], policy.act(policy.start(arena.spec), y, reference)[1]
    )
    other = tf.LoopSpec(arena.spec.measurements, arena.spec.commands[:1], 0.01, 1)
    with pytest.raises(
        tf.InputError, match="policy: expected a loop with commands torque, tension_x, tension_y, got torque"
    ):
        law.start(other)
    whole = file.read_bytes()
    for damaged in (whole[:200], b"", whole[:-50], b"not an archive"):
        file.write_bytes(damaged)
        with pytest.raises(tf.InputError, match=r"p\.npz: expected a policy") as caught:
            tf.PolicyLaw(str(file))
        assert "\n" not in str(caught.value)
        assert "pickle" not in str(caught.value)
    with np.load(policy.save(tmp_path / "q.npz")) as kept:
        arrays = dict(kept)
    arrays["weights_1"] = arrays["weights_1"][:2]
    np.savez(tmp_path / "q.npz", **arrays)
    with pytest.raises(tf.InputError, match="weights_1 is not of shape"):
        tf.Policy.load(tmp_path / "q.npz")
    with pytest.raises(tf.InputError, match="no such file"):
        tf.Policy.load(tmp_path / "none.npz")


@pytest.mark.slow
def test_policies_that_come_with_the_package_are_those_of_the_docs():
    """By its name, from a case file too, and better than ZVD + PD in an episode of the reduced model."""
    law = tf.PolicyLaw("tautflex/Slew-v0")
    page = (Path(__file__).parents[2] / "docs" / "learning.md").read_text(encoding="utf-8")
    for name in SHIPPED:
        shipped = tf.Policy.load(name)
        told = f"--iterations {shipped.told['iterations']} --seed {shipped.told['seed']}` | `{shipped.digest}`"
        assert f'`tf.PolicyLaw("{name}")` | `tautflex train slew.toml -o policy.npz {told} |' in page
    assert tf.Policy.load("some/folder/tautflex/Slew-v0").digest == law.policy.digest
    whole = Arena(task_case("slew"))
    numbers = (24.7, 25.3, 7.45, 3.77, 2.295, 0.0079, 0.0078)  # as `tune_law` finds them
    shaped = with_numbers(baseline("zvd+pd", whole), iter(numbers))
    costs = [judging.play(whole, each, tf.Scenario(whole.task.nominal()), "reduced")["cost"] for each in (law, shaped)]
    assert costs[0] < 0.9 * costs[1] < 2.5


@pytest.mark.slow
def test_a_policy_stands_in_a_case_file(policy, tmp_path):
    policy.save(tmp_path / "p.npz")
    case = coarse("slew", solver={"end_time": 0.05})
    text = case.to_toml().partition("[controller]")
    rest = text[2].partition("\n[")[2]
    (tmp_path / "c.toml").write_text(f'{text[0]}[controller]\nkind = "policy"\nfile = "p.npz"\n\n[{rest}')
    run = tf.control_case(load_case(tmp_path / "c.toml"))
    assert np.isfinite(run.data["command"].values[:-1]).all()


@pytest.mark.slow
def test_an_evaluation_says_that_it_begins(monkeypatch, capsys):
    """Commands have nothing else to tell while plants are compiled, unless a terminal follows."""
    monkeypatch.setattr(compiling, "announcing", True)
    monkeypatch.setattr(judging, "start_on", lambda *given: None)
    monkeypatch.setattr(judging, "_played", lambda *given: ((job, dict.fromkeys(METRICS, 0.0)) for job in given[3]))
    asked = {"laws": {"pd": tf.PD(30.0, 22.0, 7.46)}, "case": coarse("slew", 0.1), "plants": ("full",)}
    asked["scenarios"] = [tf.Scenario({"angle": 0.3}), tf.Scenario({"angle": 0.5})]
    tf.evaluate(**asked)
    assert "tautflex: judging on 2 episodes" in capsys.readouterr().err
    said = []
    tf.evaluate(**asked, progress=lambda fraction, message: said.append((fraction, message.split()[0])))
    assert said[0] == (0.0, "judging")
    assert said[-1][0] == 1.0
    assert capsys.readouterr().err == ""


@pytest.mark.slow
def test_evaluations_are_paired_kept_and_go_on(tmp_path, monkeypatch):
    case = coarse("slew", 0.1)
    laws = {"pd": tf.PD(30.0, 22.0, 7.46), "soft": tf.PD(3.0, 2.0, 7.46)}
    asked = {"scenarios": scenarios_of(case.task.build(), 2, (-0.05, 0.0), 1), "plants": ("full",), "workers": 1}
    first = tf.evaluate(laws, case, directory=tmp_path, **asked)
    assert dict(first.sizes) == {"law": 2, "scenario": 4, "plant": 1}
    assert len(list(tmp_path.glob("*.json"))) == 8
    angles = [float(word.split()[2].rstrip(",")) for word in first["words"].values]
    assert first["cost"].values[:, np.argmax(angles), 0].min() > first["cost"].values[:, np.argmin(angles), 0].max()

    calls = []
    real = judging._play
    monkeypatch.setattr(judging, "_play", lambda *given: calls.append(given) or real(*given))
    assert tf.evaluate(laws, case, directory=tmp_path, **asked).identical(first)
    assert calls == []
    damaged = sorted(tmp_path.glob("*.json"))[0]
    damaged.write_text("{")
    assert tf.evaluate(laws, case, directory=tmp_path, **asked).identical(first)
    assert len(calls) == 1
    told = summary(first)
    assert told["pd"]["difference"]["mean"] == 0.0
    assert told["pd"]["interval"][0] <= told["pd"]["cost"] <= told["pd"]["interval"][1]
    assert told["pd"]["worst_cost"] == first["cost"].sel(law="pd").values.max()


@pytest.mark.slow
def test_weak_actuators_act_in_part_and_no_law_knows(arena):
    """A wheel at 80 % turns the hub by 80 %; the law's own limit is met before."""
    case = coarse("slew", 0.1)
    push = Push()
    asked = {"case": case, "plants": ("reduced",), "workers": 1}
    both = [tf.Scenario(QUIET, weak=weak) for weak in ({}, {"torque": 0.8})]
    found = tf.evaluate({"push": push}, scenarios=both, **asked)
    work = found["work"].values[0, :, 0]
    assert work[1] == pytest.approx(0.64 * work[0], rel=1e-3)
    assert "torque at 80%" in str(found["words"].values[1])
    with pytest.raises(tf.InputError, match=r"weak: expected the name of an actuator.*'torqe'"):
        tf.evaluate({"push": push}, scenarios=[tf.Scenario(QUIET, weak={"torqe": 0.8})], **asked)


@pytest.mark.slow
def test_failures_are_listed_and_cost_the_worst():
    case = coarse("slew", 0.2, task={"duration": 0.2, "attitude_limit": 0.21})
    asked = {"scenarios": [tf.Scenario({**QUIET, "angle": 0.205})], "plants": ("full",), "workers": 1}
    found = tf.evaluate({"away": lambda time, y: [-5.0, 0.0, 0.0]}, case, **asked)
    failed = float(found["failed_at"].values.item())
    assert found.attrs["failures"] == [f"away, full: angle = 0.205, tension +0%, seed 0, failed at {failed:.3g} s"]
    # theta = -T t^2 / 2J reaches -5 mrad after 0.12 s
    assert failed == pytest.approx(np.sqrt(2.0 * 0.005 * 7.485 / 5.0), abs=0.011)
    assert float(found["cost"].values.item()) == case.task.build().worst_cost
    assert summary(found)["away"]["failures"] == 1


def test_numbers_of_laws_are_found_and_put_back(arena):
    law = baseline("zvd+pd", arena) + tf.LQG({"film": 1e-5}, {"torque": 2.0}, modes=4)
    numbers = list(numbers_of(law))
    assert 1e-5 in numbers
    again = with_numbers(law, iter(numbers))
    assert list(numbers_of(again)) == numbers
    doubled = with_numbers(law, iter([2.0 * value for value in numbers]))
    assert list(numbers_of(doubled)) == [2.0 * value for value in numbers]
    assert doubled.laws[1].modes == 4


class Push(tf.ControlLaw):
    """Law that asks for more than the wheel has."""

    def start(self, spec):
        return None

    def act(self, memory, measurement, reference):
        return memory, np.array([9.0, 0.0, 0.0])


class Curious(tf.ControlLaw):
    """Law that keeps the model that it is told."""

    def start(self, spec):
        self.told = spec.plant("Curious")

    def act(self, memory, measurement, reference):
        return memory, np.zeros(3)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["full", "reduced"])
def test_laws_are_not_told_of_errors_of_the_tension(kind):
    """The judged plant is off by 5 %; the frequencies that a law is told are those without, 2.5 % apart."""
    case, law = coarse("slew", 0.1), Curious()
    known, off = Arena(case), Arena(tensioned(case, 0.05))
    judging.play(off, law, tf.Scenario(QUIET, 0.05), kind, known=known)
    assert np.array_equal(law.told.stiffness, known.model.stiffness)
    ratio = np.sqrt(off.model.stiffness.diagonal()[1] / known.model.stiffness.diagonal()[1])
    assert ratio == pytest.approx(np.sqrt(1.05), rel=1e-2)


@pytest.mark.slow
def test_an_optimal_law_by_name_leaves_the_modes_beyond_its_own_stable():
    """Eight modes do not on the registered antenna."""
    whole = Arena(task_case("slew"))
    law = baseline("lqg", whole)
    with pytest.raises(tf.InputError, match="spillover"):
        start_on(replace(law, modes=8), whole)
    start_on(law, whole)


def test_first_guesses_know_the_plant(arena):
    law = baseline("pd", arena)
    assert law.inertia == pytest.approx(7.485, rel=1e-3)  # hub 5 kg m^2 and the antenna's 2.485 about x
    for name, words in (("fuzzy", "'fuzzy'"), ("zvd", "got none"), ("zvd+pd+x", "'zvd\\+pd\\+x'")):
        with pytest.raises(tf.InputError, match=words):
            baseline(name, arena)


@pytest.mark.slow
def test_tuning_spends_its_budget_and_keeps_the_best(arena):
    found = tf.tune_law(tf.PD(3.0, 2.0, 7.46), arena.case, seconds=6.0, plant="full")
    assert (found.trials, found.seconds) == (6, pytest.approx(5.4))
    assert found.cost < found.before


@pytest.mark.slow
def test_command_line(tmp_path, capsys, policy):
    case = tmp_path / "slew.toml"
    case.write_text(coarse("slew", 0.05).to_toml())
    words = ["evaluate", str(case), "--law", "case", "--budget", "0", "--plant", "full", "--angles", "1"]
    words += ["--seeds", "1", "--workers", "1", "-o", str(tmp_path / "judged"), "--json"]
    assert main(words) == 0
    answer = json.loads(capsys.readouterr().out)
    assert set(answer["laws"]["case"]) >= {"cost", "settling_time", "surface_rms", "worst_cost"}
    assert answer["scenarios"] == 3
    assert (tmp_path / "judged" / "evaluation.nc").is_file()
    assert main(["evaluate", str(case), "--law", "foo"]) == 2
    assert "'foo'" in capsys.readouterr().err


@pytest.mark.slow
def test_episodes_of_the_compiled_plant_are_those_of_the_loop(arena):
    """The judge's fast way on the reduced model against `close_loop` on `Plant` of the same model."""
    law, parameters = tf.PD(30.0, 22.0, 7.46), {**QUIET, "angle": 0.3}
    found = judging.play(arena, law, tf.Scenario(parameters), "reduced")
    plant = tf.Plant(
        arena.reduced,
        arena.hub,
        arena.actuators,
        arena.sensors,
        interval=arena.interval,
        time_step=arena.case.solver.time_step,
        damping=arena.damping,
        method=tf.CentralDifference(),
    )
    data = close_loop(plant, law, arena.task.maneuver(parameters), arena.task.duration).data
    rms = data["surface_rms"].values[1:]
    turned = 2.0 * np.arcsin(data["attitude"].values[1:, 1])
    assert found["cost"] == pytest.approx(arena.task.cost(turned - 0.3, rms).mean(), rel=1e-9)
