"""Many episodes side by side, as Gymnasium has them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.case.schema import Case
from tautflex.control.sensors.sensor import Sensor
from tautflex.errors import InputError
from tautflex.learning.arena import Arena
from tautflex.learning.cases import case_of
from tautflex.learning.environments.gym import AutoresetMode, VectorEnv, gymnasium
from tautflex.learning.environments.loops import TERMS, Loops
from tautflex.learning.environments.rendering import picture
from tautflex.numeric import Array, Mask


class VectorAntennaEnv(VectorEnv[Array, Array, Array]):
    """Antennas under commands, one array program; row i with seed s is a single environment with seed s + i.

    Parameters
    ----------
    num_envs
        How many.
    task, plant, case, actuators, sensors, coordinates
        As of `AntennaEnv`.
    autoreset_mode
        ``NEXT_STEP``: the step after an episode's last one begins the next, whatever its action; ``SAME_STEP``: the
        last step itself does, and ``info["final_obs"]`` has what was seen last; ``DISABLED``: episodes that are over
        stay, ``reset(options={"reset_mask": ...})`` begins chosen ones.
    render_mode
        ``"rgb_array"``.

    Raises
    ------
    InputError
        If an argument is wrong.
    """

    def __init__(
        self,
        num_envs: int = 1,
        task: str = "slew",
        plant: str = "reduced",
        case: Case | str | PathLike[str] | None = None,
        actuators: Mapping[str, Any] | None = None,
        sensors: Mapping[str, Sensor] | None = None,
        coordinates: int | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
    ) -> None:
        modes = {mode.value: mode for mode in AutoresetMode} | {mode.name: mode for mode in AutoresetMode}
        given = getattr(autoreset_mode, "value", autoreset_mode)
        self._mode = modes[checks.one_of("autoreset_mode", given, tuple(modes))]
        if render_mode is not None:
            checks.one_of("render_mode", render_mode, ("rgb_array",))
        self.num_envs, self.render_mode = checks.whole("num_envs", num_envs, 1), render_mode
        self.metadata = {"autoreset_mode": self._mode, "render_modes": ["rgb_array"], "render_fps": 25}
        self.arena = Arena(case_of(case, task), None, actuators, sensors, coordinates)
        self._loops = Loops(self.arena, plant, self.num_envs)
        box = gymnasium.spaces.Box
        self.single_action_space = box(-1.0, 1.0, (len(self.arena.limits),), np.float64)
        self.single_observation_space = box(-1.0, 1.0, (self.arena.observation.size,), np.float64)
        self.action_space = gymnasium.vector.utils.batch_space(self.single_action_space, num_envs)
        self.observation_space = gymnasium.vector.utils.batch_space(self.single_observation_space, num_envs)
        self._random: list[np.random.Generator] = []

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begin episodes: all, or those of ``options["reset_mask"]``; other options set parameters for all of them."""
        given = checks.mapping("options", options)
        mask = np.ones(self.num_envs, dtype=bool)
        if "reset_mask" in given:
            mask = np.asarray(given.pop("reset_mask"))
            if mask.shape != (self.num_envs,) or mask.dtype != bool or not mask.any():
                raise InputError(
                    f"options.reset_mask: expected {self.num_envs} truth values, one at least True, got {mask!r}; "
                    "give an array of bool"
                )
        seeds: Sequence[int | None]
        if seed is None:
            seeds = [None] * self.num_envs
        elif isinstance(seed, Sequence | np.ndarray):
            seeds = [None if one is None else checks.whole("seed", one, 0) for one in seed]
        else:
            first = checks.whole("seed", seed, 0)
            seeds = [first + row for row in range(self.num_envs)]
        if len(seeds) != self.num_envs:
            raise InputError(f"seed: expected one or {self.num_envs} numbers, got {len(seeds)}; give one for each")
        for row, own in enumerate(seeds):
            if len(self._random) <= row:
                self._random.append(gymnasium.utils.seeding.np_random(own)[0])
            elif own is not None and mask[row]:
                self._random[row] = gymnasium.utils.seeding.np_random(own)[0]
        info = self._begin(mask, given)
        return self._loops.seen.copy(), info

    def _begin(self, mask: Mask, options: Mapping[str, Any] | None = None) -> dict[str, Any]:
        rows = np.flatnonzero(mask).tolist()
        for row in rows:
            self._loops.reset(row, self._random[row], options)
        drawn = {name: np.zeros(self.num_envs) for name in self.arena.task.drawn}
        for name, values in drawn.items():
            values[rows] = [self._loops.parameters[row][name] for row in rows]
        return drawn | {f"_{name}": mask.copy() for name in drawn}

    def step(self, actions: Array) -> tuple[Array, Array, Any, Any, dict[str, Any]]:
        """Hold actions over one interval, shape (num_envs, commands)."""
        loops = self._loops
        if not self._random:
            raise InputError("step: expected reset before this, got none; call observations, info = env.reset(seed=0)")
        done = loops.terminated | loops.truncated
        if done.any() and self._mode is AutoresetMode.DISABLED:
            raise InputError(
                f"step: expected episodes that go on, got {int(done.sum())} that have ended; reset them with "
                "reset(options={'reset_mask': ...})"
            )
        loops.take(actions, loops.actions.shape)
        loops.step()
        going = ~done
        info: dict[str, Any] = dict(zip(TERMS, loops.terms.T.copy(), strict=True))
        info |= {f"_{name}": going for name in TERMS}
        reward, terminated, truncated = loops.reward.copy(), loops.terminated.copy(), loops.truncated.copy()
        if done.any():  # what ended before begins now
            info |= self._begin(done)
            reward[done], terminated[done], truncated[done] = 0.0, False, False
        elif self._mode is AutoresetMode.SAME_STEP and (over := terminated | truncated).any():
            last = np.full(self.num_envs, None, dtype=object)
            for row in np.flatnonzero(over).tolist():
                last[row] = loops.seen[row].copy()
            told = {name: info[name].copy() for name in TERMS} | {f"_{name}": over for name in TERMS}
            info |= {"final_obs": last, "_final_obs": over, "final_info": told, "_final_info": over}
            info |= self._begin(over)
        return loops.seen.copy(), reward, terminated, truncated, info

    def render(self) -> Any:
        """Pictures of all antennas, arrays (height, width, 3)."""
        if self.render_mode is None:
            return None
        return tuple(picture(self._loops, row) for row in range(self.num_envs))
