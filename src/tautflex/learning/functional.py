"""An environment as pure functions in JAX, over the reduced plant: differentiable, and made for many at once.

The same plant, drives, disturbances, readings, observation and reward as the environments have on their reduced models.
Slopes are those of reverse mode. Arrays may have the run as last axis (fast), or be those of one run, for `jax.vmap`.
"""

from __future__ import annotations

from os import PathLike
from typing import Any, NamedTuple

import numpy as np

from tautflex import checks
from tautflex.batch.library import PRECISIONS, jax, jnp
from tautflex.case.schema import Case
from tautflex.learning.arena import Arena
from tautflex.learning.cases import case_of
from tautflex.learning.twin_constants import TwinConstants
from tautflex.learning.twin_steps import Motion, TwinSteps

Array = jax.Array
Params = dict[str, Any]

# Mean squares of the film's deflection below this [m^2] have no slope, so that there is one at rest.
_NO_SLOPE = 1e-30


class TwinState(NamedTuple):
    """What an episode depends on from here on.

    Parameters
    ----------
    motion
        Coordinates and hub.
    waiting, target, output, value
        Of the drives, shapes (k, c), (c,), (c,), (c,).
    measured
        Last measurement, shape (o,).
    action
        Last one, shape (commands,).
    place
        Intervals since the reset.
    over
        Whether the episode has ended; then nothing changes any more and rewards are 0.
    """

    motion: Motion
    waiting: Array
    target: Array
    output: Array
    value: Array
    measured: Array
    action: Array
    place: Array
    over: Array


class FunctionalTwin:
    """Pure functions of a task about one axis: a slew, to hold a hub, or a prescribed stop.

    Parameters
    ----------
    arena
        Structure, loop and task; or the case, or its file, that has them; None is ``tautflex/Slew-v0``.
    precision
        ``"double"``, or ``"single"``: faster, and less exact, see docs/batch.md.

    Attributes
    ----------
    steps
        Of an episode.

    Raises
    ------
    UnsupportedError
        If task, hub, sensors or damping have no functional form.
    MissingExtraError
        If JAX is not installed.
    """

    def __init__(self, arena: Arena | Case | str | PathLike[str] | None = None, precision: str = "double") -> None:
        checks.one_of("precision", precision, PRECISIONS)
        kind = jnp.float64 if precision == "double" else jnp.float32
        if not isinstance(arena, Arena):
            arena = Arena(case_of(arena, "slew"))
        self.arena, self.steps, self.kind = arena, arena.steps, kind
        c = self._constants = TwinConstants.of(arena)
        self._task, self._moving = arena.task, TwinSteps(c, kind)
        self.commands, self.observed = len(arena.limits), arena.observation.size
        self._late = int(c.delay.max(initial=0))
        self._units = np.zeros(len(c.limit))
        self._units[len(self._units) - len(arena.tension_units) :] = arena.tension_units
        seen = arena.observation
        self._matrix, self._knee = jnp.asarray(seen.matrix, kind), jnp.asarray(seen.knee, kind)[:, None]
        self._span = jnp.asarray(np.arcsinh(seen.largest / seen.knee), kind)[:, None]

    def params(self) -> Params:
        """Parameters of a nominal episode.

        Beside what the task draws: factors of linear ``stiffness`` and of ``damping``, and ``delay``, the part of an
        interval in [0, 1] by which commands act late.
        """
        return {**self._task.nominal(), "stiffness": 1.0, "damping": 1.0, "delay": 0.0}

    def draw(self, key: Array, count: int, ranges: dict[str, tuple[float, float]] | None = None) -> Params:
        """Parameters of episodes, each uniform in its range, shape (count,).

        Parameters
        ----------
        key
            Of `jax.random`.
        count
            How many.
        ranges
            Least and largest value by name, in place of those of the task.
        """
        limits = {**self._task.limits(), **(ranges or {})}
        nominal = self.params()
        for name in limits:
            checks.one_of("ranges", name, tuple(nominal))
        found = {name: jnp.full(count, value, self.kind) for name, value in nominal.items()}
        for number, (name, (low, high)) in enumerate(sorted(limits.items())):
            own = jax.random.fold_in(key, number)
            found[name] = jax.random.uniform(own, (count,), self.kind, low, high)
        return found

    def reset(self, key: Array, params: Params) -> tuple[TwinState, Array]:
        """Begin an episode: state and observation.

        Parameters
        ----------
        key
            Of `jax.random`: the noise of the first measurement.
        params
            As of `params`; numbers, or shape (n,) for n episodes, the last axis of everything.
        """
        alone = jnp.ndim(params[self._task.drawn[0]]) == 0
        wide = self._wide(params)
        state, seen = self._reset(self.draws(key, self._runs(wide)), wide)
        return (_narrow(state), seen[:, 0]) if alone else (state, seen)

    def step(
        self, key: Array, state: TwinState, action: Any, params: Params
    ) -> tuple[TwinState, Array, Array, Array, Array, dict[str, Array]]:
        """One interval.

        Parameters
        ----------
        key
            Of `jax.random`: the noise of this measurement.
        state
            Where the episode stands.
        action
            In [-1, 1], shape (commands,) or (commands, n).
        params
            As of `reset`.

        Returns
        -------
        tuple
            State, observation, reward, whether it terminated, whether time is up, and ``"attitude_error"`` [rad],
            ``"surface_rms"`` [m] and ``"cost"``.
        """
        alone = state.place.ndim == 0
        action = jnp.asarray(action, self.kind)
        if not alone:
            return self.step_drawn(self.draws(key, len(state.place)), state, action, params)
        wide = jax.tree.map(lambda part: part[..., None], state)
        narrow: Any = _narrow(self.step_drawn(self.draws(key, 1), wide, action[:, None], params))
        return narrow

    def draws(self, key: Array, runs: int) -> Array:
        """Standard normal numbers of a measurement, shape (o, n)."""
        shape = len(self._constants.noise), runs
        return jax.random.normal(key, shape, self.kind) if self._constants.noise.any() else jnp.zeros(shape, self.kind)

    def _wide(self, params: Params) -> Params:
        return {
            name: jnp.atleast_1d(jnp.asarray(params.get(name, value), self.kind))
            for name, value in self.params().items()
        }

    def _runs(self, params: Params) -> int:
        return len(jnp.broadcast_arrays(*params.values())[0])

    def _reset(self, drawn: Array, params: Params) -> tuple[TwinState, Array]:
        runs, c = self._runs(params), self._constants
        count = len(c.limit)
        value = self._units[:, None] * params["tension_error"] + jnp.zeros((count, runs), self.kind)
        value = jnp.asarray(value, self.kind)
        none, start = jnp.zeros((count, runs), self.kind), jnp.zeros(runs, jnp.int32)
        still = self._turn(self._moving.rest(runs), start, params)
        motion = self._moving.jump(still, self._moving.given(value, none)[1])
        state = TwinState(
            motion,
            jnp.zeros((self._late, count, runs), self.kind),
            none,
            none,
            value,
            jnp.zeros((len(c.noise), runs), self.kind),
            jnp.zeros((self.commands, runs), self.kind),
            start,
            jnp.zeros(runs, bool),
        )
        measured = self._measure(drawn, state, params)
        return state._replace(measured=measured), self._see(state, measured, measured, params)

    def step_drawn(self, drawn: Array, state: TwinState, action: Array, params: Params) -> Any:
        """`step` of n episodes whose noise is drawn already: so a slope need not draw it twice."""
        task, moving, params = self._task, self._moving, self._wide(params)
        action = jnp.clip(action, -1.0, 1.0)
        waiting, target, output, value = self._drive(state, action, params)
        given, change = moving.given(value, state.value)
        motion = moving.interval(moving.jump(state.motion, change), given, params["stiffness"], params["damping"])
        place = state.place + 1
        motion = self._turn(motion, place, params)
        moved = TwinState(motion, waiting, target, output, value, state.measured, action, place, state.over)
        error = 0.0 * motion.angle if self._constants.driven else motion.angle - task.goal(params)
        form = jnp.asarray(self._constants.form, self.kind)
        square = jnp.sum((form @ motion.q) * motion.q, axis=0)
        rms = jnp.sqrt(jnp.maximum(square, _NO_SLOPE))
        cost = task.cost(error, rms, jnp)
        paid = task.reward(error, rms, action.T, state.action.T, jnp)
        failed = task.failed(error, rms, jnp) | ~jnp.isfinite(square)
        worst = task.worst_reward(self.commands) * (self.steps - place + 1)
        reward = jnp.where(state.over, 0.0, jnp.where(failed, worst, paid))
        terminated, late = failed & ~state.over, (place >= self.steps) & ~failed & ~state.over
        # What has failed may hold no numbers; it stays where it was.
        stays = state.over | failed
        kept = jax.tree.map(lambda new, old: jnp.where(stays, old, new), moved, state)
        kept = kept._replace(over=stays | late, place=jnp.where(state.over, state.place, place))
        measured = self._measure(drawn, kept, params)
        seen = self._see(kept, measured, state.measured, params)
        info = {"attitude_error": error, "surface_rms": rms, "cost": jnp.where(failed, task.worst_cost, cost)}
        return kept._replace(measured=measured), seen, reward, terminated, late, info

    def _turn(self, motion: Motion, place: Array, params: Params) -> Motion:
        """A prescribed motion at the start of an interval; as it is where the hub is free."""
        if not self._constants.driven:
            return motion
        _, *rates = self._task.reference(self._time(place), params, jnp)
        return self._moving.turn(motion, *(jnp.asarray(each, self.kind) for each in rates))

    def _time(self, place: Array) -> Array:
        return (self.arena.interval * place).astype(self.kind)

    def _drive(self, state: TwinState, action: Array, params: Params) -> tuple[Array, Array, Array, Array]:
        """Memory of the drives, and what acts over the interval; see `Drive.act`."""
        c, interval = self._constants, self.arena.interval
        gain = self.arena.limits[:, None] * (1.0 + (params["effectiveness"] - 1.0) * self.arena.on_structure[:, None])
        late = params["delay"]
        asked = gain * ((1.0 - late) * action + late * state.action)
        disturbed = self._task.acting(params, state.place, interval, jnp)
        errors = self._units[self.commands + len(disturbed) :, None] * params["tension_error"]
        command = jnp.concatenate([asked, *(each[None] for each in disturbed), errors]).astype(self.kind)

        def column(part: Any) -> Array:
            return jnp.asarray(part, self.kind)[:, None]

        waiting, target = state.waiting, command
        if self._late:
            # The oldest last; a number of its own delay k reads place k.
            line = jnp.concatenate([command[None], waiting])
            target = line[np.asarray(c.delay), np.arange(len(c.delay))]
            waiting = line[:-1]
        if c.resolution.any():
            fine = column(np.where(c.resolution > 0.0, c.resolution, 1.0))
            target = jnp.where(column(c.resolution) > 0.0, fine * jnp.round(target / fine), target)
        target = jnp.clip(target, -column(c.limit), column(c.limit))
        reach = column(c.rate * interval)
        if np.isfinite(c.rate).any():
            target = state.target + jnp.clip(target - state.target, -reach, reach)
        output = value = target
        if c.lag.any():
            lag = np.where(c.lag > 0.0, c.lag, 1.0)
            left, decay = state.output - target, column(np.where(c.lag > 0.0, np.exp(-interval / lag), 0.0))
            output = target + decay * left
            value = target + left * column(c.lag / interval) * (1.0 - decay)
        return waiting, target, output, jnp.maximum(value, column(c.lowest))

    def _measure(self, drawn: Array, state: TwinState, params: Params) -> Array:
        """Noisy readings, shape (o, n)."""
        c, at = self._constants, state.motion

        def of(part: Any) -> Array:
            return jnp.asarray(part, self.kind)

        found = of(c.level + c.bias)[:, None] + of(c.look) @ at.q
        found += of(c.rotation)[:, None] * at.angle + of(c.spinning)[:, None] * at.rate
        if c.look_value.any():
            found += of(c.look_value) @ state.value
        if c.look_acceleration.any() or c.look_square.any():
            found += of(c.look_acceleration)[:, None] * at.acceleration + of(c.look_square)[:, None] * at.rate**2
        if c.look_follow is not None:
            found += of(c.look_follow) @ self._moving.monomials.values(at.q)
        if c.speed.any():
            found += of(c.speed) @ at.v
        if c.speed_follow is not None:
            found += of(c.speed_follow) @ self._moving.monomials.rates(at.q, at.v)
        if c.noise.any():
            found += params["noise"] * of(c.noise)[:, None] * drawn
        if c.reading_resolution.any():
            fine = of(np.where(c.reading_resolution > 0.0, c.reading_resolution, 1.0))[:, None]
            found = jnp.where(of(c.reading_resolution)[:, None] > 0.0, fine * jnp.round(found / fine), found)
        return found

    def reference(self, time: Array, params: Params) -> Array:
        """Attitude, rate and acceleration of the turn that laws follow, and attitude of the goal, shape (4, n).

        Shape (0, n) where there is no hub that could follow.
        """
        if self._constants.driven:
            return jnp.zeros((0, *jnp.shape(time)), self.kind)
        return jnp.stack([*self._task.reference(time, params, jnp), self._task.goal(params) + 0.0 * time])

    def features(self, state: TwinState, measured: Array, before: Array, params: Params) -> Array:
        """Measurement, the one before, and the reference: what a linear law sees, shape (z, n)."""
        return jnp.concatenate([measured, before, self.reference(self._time(state.place), params)])

    def _see(self, state: TwinState, measured: Array, before: Array, params: Params) -> Array:
        z = self.features(state, measured, before, params)
        seen = jnp.arcsinh(self._matrix @ z / self._knee) / self._span
        to_go = 1.0 - 2.0 * (self.arena.interval * state.place / self._task.duration).astype(self.kind)
        return jnp.clip(jnp.concatenate([seen, state.action, to_go[None]]), -1.0, 1.0)


def _narrow(tree: Any) -> Any:
    """One run of one."""
    return jax.tree.map(lambda part: part[..., 0], tree)
