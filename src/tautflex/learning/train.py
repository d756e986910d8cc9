"""Training: a network learns behind a linear law by the slope of its reward, on the functional twin."""

from __future__ import annotations

import hashlib
import json
import os
import time as clock
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tautflex import checks, compiling
from tautflex.batch.library import jax, jnp, threadpool_limits
from tautflex.case.schema import Case
from tautflex.control.law import ControlLaw
from tautflex.control.tasks.policy import Policy
from tautflex.errors import InputError, MissingExtraError
from tautflex.files.transaction import result_file
from tautflex.interrupts import deferred, meet
from tautflex.learning.arena import Arena
from tautflex.learning.cases import case_of
from tautflex.learning.functional import FunctionalTwin
from tautflex.learning.gain import linear_gain
from tautflex.learning.rollout import Course, Layers, Rollouts, start_layers
from tautflex.numeric import Array
from tautflex.writing import written

try:
    import optax
except ImportError as error:
    raise MissingExtraError(
        "train: expected the package optax, which is not installed; pip install 'tautflex[batch,control]'"
    ) from error

# Keys of what is drawn, apart from each other: first layers, episodes, noise, validation.
_LAYERS, _EPISODES, _NOISE, _JUDGED = range(4)
# What a model is wrong in beside what the task draws: factors of stiffness and damping, and how late commands act.
_DOUBTS = {"stiffness": (0.96, 1.04), "damping": (0.7, 1.4), "delay": (0.0, 1.0)}
_MEAN = 0.95  # part of the running mean of the iterates that stays in an iteration
Progress = Callable[[float, str], None]


@dataclass(frozen=True)
class Trained:
    """What a training leaves.

    Parameters
    ----------
    policy
        The best running mean of iterates, by its cost on episodes of a model that training never sees.
    cost
        Its cost there.
    start_cost
        That of the law alone that it started from.
    iterations, costs
        When the policy was judged, and its mean cost then, shape (n,).
    skipped
        Iterations whose slope was no number, and which changed nothing.
    """

    policy: Policy
    cost: float
    start_cost: float
    iterations: Array
    costs: Array
    skipped: int


class _Learner(NamedTuple):
    """All that the next iteration depends on, beside its number."""

    layers: Layers
    mean: Layers
    optimizer: Any
    course: Course
    params: dict[str, Any]
    best: Layers
    best_cost: Any
    skipped: Any


def train(
    task: str = "slew",
    *,
    case: Case | str | os.PathLike[str] | None = None,
    law: str | ControlLaw | None = None,
    iterations: int = 2000,
    seconds: float | None = None,
    seed: int = 0,
    layers: Sequence[int] = (32, 32),
    runs: int = 48,
    horizon: int | None = None,
    smoothing: float = 0.03,
    learning_rate: float = 3e-3,
    clip: float = 1.0,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    judge_every: int = 50,
    judged: int = 16,
    coordinates: int | None = None,
    judge_coordinates: int | None = None,
    precision: str = "single",
    checkpoint: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> Trained:
    """Train a policy by the slope of its reward.

    A network learns behind a linear law. Each iteration lets many episodes go on over a horizon, follows the reward's
    slope back through plant and policy, clips it, and takes a step of Adam; then the next horizon of the same episodes
    follows. Parameters of episodes are drawn from their ranges, so that the policy holds where the model is wrong.

    A policy drives modes that the model of its training has not: the eight coordinates of ``tautflex/Slew-v0`` lack
    four modes between 4.5 and 7 Hz that its torque reaches. So it is trained on more coordinates, behind a lag, and the
    running mean of the iterates is judged on a model of still more.

    Parameters
    ----------
    task
        ``"slew"``, ``"stop"`` or ``"hold"``.
    case
        Case, or its file, with a [task]; None is that of the task.
    law
        Linear law without memory that the network learns behind: a name as of `baseline`, or a law. None is ``"pd"``,
        and ``"none"`` where there is no hub.
    iterations
        Steps of Adam.
    seconds
        Time after which training ends before that [s]; None is none. How far it comes depends on the machine.
    seed
        Decides everything that is drawn.
    layers
        Units of the hidden layers.
    runs
        Episodes side by side.
    horizon
        Intervals that a slope is followed back through; a whole part of an episode. None is the largest up to 250: what
        comes behind a horizon counts nothing, so it must be longer than the turn.
    smoothing
        Time constant of the lag behind the network [s], >= 0.
    learning_rate
        Of Adam.
    clip
        Largest norm of a slope.
    ranges
        Least and largest value of parameters of an episode, in place of those of the task; also of ``"stiffness"``
        (0.96 to 1.04), ``"damping"`` (0.7 to 1.4) and ``"delay"`` (0 to 1), see `FunctionalTwin.params`. Equal ones
        switch the drawing off.
    judge_every, judged
        After how many iterations the policy is judged, and on how many episodes, which training never sees.
    coordinates, judge_coordinates
        Of the reduced models that it is trained and judged on; None is 3/2 of the task's, and one more than its double.
    precision
        ``"double"`` or ``"single"``.
    checkpoint
        File (.npz) in which training is kept wherever the policy is judged; from there it goes on, to the same policy,
        where it was killed or is asked for more iterations. None keeps nothing.
    progress
        Called with the fraction done and a short message.

    Returns
    -------
    Trained

    Raises
    ------
    InputError
        If an argument is out of range, or a checkpoint is damaged or of another training.
    UnsupportedError
        If the task has no functional form.
    MissingExtraError
        If JAX or optax is not installed.
    """
    checks.teller(progress)
    arena = Arena(case_of(case, task))
    own = arena.task.coordinates
    arena, finer = (
        Arena(arena.case, coordinates=default if count is None else checks.whole(name, count, 3))
        for name, count, default in (
            ("coordinates", coordinates, own + own // 2),
            ("judge_coordinates", judge_coordinates, 2 * own + 1),
        )
    )
    for name, value, least in (
        ("iterations", iterations, 1), ("seed", seed, 0), ("runs", runs, 1), ("judge_every", judge_every, 1),
        ("judged", judged, 1),
    ):  # fmt: skip
        checks.whole(name, value, least)
    units = [checks.whole("layers", size, 1) for size in checks.several("layers", layers, int, "(32, 32)")]
    if seconds is not None:
        checks.positive("seconds", seconds)
    checks.positive("learning_rate", learning_rate)
    checks.positive("clip", clip)
    checks.non_negative("smoothing", smoothing)
    wanted = min(250 if horizon is None else checks.whole("horizon", horizon, 1), arena.steps)
    part = max(part for part in range(1, wanted + 1) if arena.steps % part == 0)
    # What is chosen here shall not be far shorter than what is wanted.
    if part != horizon and (horizon is not None or 2 * part < wanted):
        raise InputError(
            f"horizon: expected a whole part of an episode of {arena.steps} intervals, got {horizon}; set for example "
            f"horizon = {part}, or another task.duration"
        )
    twins = FunctionalTwin(arena, precision), FunctionalTwin(finer, precision)
    drawn = {name: (float(low), float(high)) for name, (low, high) in (_DOUBTS | dict(ranges or {})).items()}
    gain = linear_gain(("none" if arena.hub is None else "pd") if law is None else law, arena)
    keep = float(np.exp(-arena.interval / smoothing)) if smoothing else 0.0
    settings = {
        "task": task, "seed": seed, "layers": units, "runs": runs, "horizon": part, "ranges": drawn, "clip": clip,
        "learning_rate": learning_rate, "judge_every": judge_every, "judged": judged, "precision": precision,
        "smoothing": smoothing,
        "coordinates": arena.task.coordinates, "judge_coordinates": finer.task.coordinates,
    }  # fmt: skip
    words = json.dumps([settings, hashlib.sha256(gain.tobytes()).hexdigest(), repr(arena.task), repr(arena.actuators)])
    training = _Training(twins, gain, keep, settings, drawn, hashlib.sha256(words.encode()).hexdigest()[:16])
    with threadpool_limits(1, "blas"), deferred():
        if checkpoint is None:
            return training.train(iterations, None, progress, seconds)
        place = checks.path("checkpoint", checkpoint)
        with result_file(place, "checkpoint"):
            return training.train(iterations, place, progress, seconds)


class _Training:
    """One training: its compiled iterations and what it keeps."""

    def __init__(
        self, twins: tuple[FunctionalTwin, FunctionalTwin], gain: Array, keep: float, settings: dict[str, Any],
        ranges: dict[str, Any], digest: str,
    ) -> None:  # fmt: skip
        self._twin, self._finer = twin, _ = twins
        self._gain, self._keep_part, self._s, self._ranges, self._digest = gain, keep, settings, ranges, digest
        self._rollouts, self._judges = (Rollouts(each, gain, keep) for each in twins)
        self._key = jax.random.key(settings["seed"])
        self._optimizer = optax.chain(
            optax.clip_by_global_norm(settings["clip"]), optax.adam(settings["learning_rate"])
        )
        self._segments = twin.steps // settings["horizon"]
        self._iterate, self._judge = jax.jit(self._iteration), jax.jit(self._cost)
        self._draw = jax.jit(self._drawn)

    def _of(self, what: int, number: Any) -> Any:
        return jax.random.fold_in(jax.random.fold_in(self._key, what), number)

    def _drawn(self, number: Any) -> tuple[dict[str, Any], Course]:
        """Parameters and beginnings of the episodes that start with an iteration."""
        params = self._twin.draw(self._of(_EPISODES, 2 * number), self._s["runs"], self._ranges)
        return params, self._rollouts.begin(self._of(_EPISODES, 2 * number + 1), params)

    def _cost(self, layers: Layers) -> Any:
        params = self._finer.draw(self._of(_JUDGED, 0), self._s["judged"])
        return jnp.mean(self._judges.cost(layers, self._of(_JUDGED, 1), params))

    def _iteration(self, at: _Learner, number: Any) -> tuple[_Learner, Any]:
        """One step of Adam."""
        key = self._of(_NOISE, number)
        mean, slope, course = self._rollouts.slope(at.layers, key, at.course, at.params, self._s["horizon"])
        downhill = jax.tree.map(jnp.negative, slope)
        good = jnp.isfinite(sum(jnp.vdot(part, part) for part in jax.tree.leaves(slope)))
        change, optimizer = self._optimizer.update(downhill, at.optimizer, at.layers)
        moved = optax.apply_updates(at.layers, change), optimizer
        layers, optimizer = jax.tree.map(lambda new, old: jnp.where(good, new, old), moved, (at.layers, at.optimizer))
        running = jax.tree.map(lambda old, new: _MEAN * old + (1.0 - _MEAN) * new, at.mean, layers)
        skipped = at.skipped + ~good
        now = at._replace(layers=layers, mean=running, optimizer=optimizer, course=course, skipped=skipped)
        return now, mean

    def _start(self) -> tuple[_Learner, float]:
        twin = self._twin
        sizes = [twin.observed, *self._s["layers"], twin.commands]
        layers = start_layers(self._of(_LAYERS, 0), sizes, twin.kind)
        still = jax.tree.map(jnp.zeros_like, layers)
        cost = self._judge(still)
        params, course = self._draw(0)
        return _Learner(
            layers, layers, self._optimizer.init(layers), course, params, still, cost, jnp.zeros((), int)
        ), float(cost)

    def train(
        self, iterations: int, place: Path | None, progress: Progress | None, seconds: float | None = None
    ) -> Trained:
        """All iterations that there is time for, from a checkpoint where there is one."""
        end = np.inf if seconds is None else clock.monotonic() + seconds
        compiling.say(progress, "compiling the training, plant and policy together ...")
        at, start = self._start()
        first, judged = 0, [(0, start)]
        if place is not None and place.exists():
            at, first, judged = self._resume(place, at)
        every = self._s["judge_every"]
        for number in range(first, iterations):
            meet()
            if number % self._segments == 0:
                params, course = self._draw(number)
                at = at._replace(params=params, course=course)
            at, mean = self._iterate(at, number)
            if number == first:
                compiling.say(progress, f"compiled, training from a cost of {judged[-1][1]:.4g} ...")
            done = number + 1
            late = seconds is not None and clock.monotonic() > end
            if done % every == 0 or done == iterations or late:
                cost = self._judge(at.mean)
                if float(cost) < float(at.best_cost):
                    at = at._replace(best=at.mean, best_cost=cost)
                judged.append((done, float(cost)))
                # What is judged at the end alone is no part of a longer training.
                if place is not None and done % every == 0:
                    self._keep(place, at, done, judged)
                if progress is not None:
                    part = done / iterations
                    if seconds is not None:
                        part = max(part, 1.0 - max(end - clock.monotonic(), 0.0) / seconds)
                    progress(part, f"cost {float(cost):.4g}, reward {float(mean):.4g}")
            if late:
                break
        return self._result(at, judged)

    def _result(self, at: _Learner, judged: list[tuple[int, float]]) -> Trained:
        arena = self._twin.arena
        told = {
            **self._s, "training": self._digest, "cost": float(at.best_cost), "start_cost": judged[0][1],
            "iterations": judged[-1][0],
        }  # fmt: skip
        layers = tuple((np.asarray(w, dtype=float), np.asarray(b, dtype=float)) for w, b in at.best)
        policy = Policy(
            arena.observation, layers, self._gain, arena.limits, arena.spec.measured, arena.spec.commanded,
            arena.interval, self._keep_part, told,
        )  # fmt: skip
        numbers, costs = (np.array(part) for part in zip(*judged, strict=True))
        return Trained(policy, float(at.best_cost), judged[0][1], numbers, costs, int(at.skipped))

    def _keep(self, place: Path, at: _Learner, done: int, judged: list[tuple[int, float]]) -> None:
        """Write a checkpoint, whole or not at all."""
        words = json.dumps({"training": self._digest, "done": done, "judged": judged})
        leaves = {f"leaf_{number}": np.asarray(leaf) for number, leaf in enumerate(jax.tree.leaves(at))}
        with written(place) as temporary, temporary.open("wb") as file:
            np.savez(file, words=np.array(words), **leaves)  # type: ignore[arg-type]

    def _resume(self, place: Path, like: _Learner) -> tuple[_Learner, int, list[tuple[int, float]]]:
        """What a checkpoint holds."""
        expected, shapes = "checkpoint: expected one of this training", jax.tree.leaves(like)
        try:
            with place.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
                words = json.loads(str(file["words"]))
                leaves = [file[f"leaf_{number}"] for number in range(len(shapes))]
            if words["training"] != self._digest:
                raise InputError(
                    f"{expected} in {place}, got that of another (other settings or seed); give another "
                    "file, or remove it"
                )
            if any(
                leaf.shape != shape.shape or leaf.dtype != shape.dtype
                for leaf, shape in zip(leaves, shapes, strict=True)
            ):
                raise ValueError("its arrays have other shapes")
            at = jax.tree.unflatten(jax.tree.structure(like), [jnp.asarray(leaf) for leaf in leaves])
            return at, int(words["done"]), [(int(number), float(cost)) for number, cost in words["judged"]]
        except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
            if isinstance(error, InputError):
                raise
            reason = " ".join(f"{type(error).__name__}: {error}".split())[:120]
            raise InputError(f"{expected} in {place}, got a damaged file ({reason}); remove it") from None
