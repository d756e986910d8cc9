"""One episode at a time, as Gymnasium has it."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.case.schema import Case
from tautflex.control.sensors.sensor import Sensor
from tautflex.errors import InputError
from tautflex.learning.arena import Arena
from tautflex.learning.cases import case_of
from tautflex.learning.environments.gym import gymnasium
from tautflex.learning.environments.loops import Loops
from tautflex.learning.environments.rendering import MODES, Screen
from tautflex.numeric import Array


class AntennaEnv(gymnasium.Env[Array, Array]):
    """An antenna under commands, see docs/learning.md.

    Parameters
    ----------
    task
        ``"slew"``, ``"stop"`` or ``"hold"``: whose case is taken where there is none.
    plant
        ``"reduced"`` for training, ``"full"`` for judging.
    case
        Case, or its file, with a [task].
    actuators, sensors
        By name, in place of those of the case.
    coordinates
        Of the reduced model, in place of those of the task.
    render_mode
        ``"rgb_array"`` or ``"human"``.

    Raises
    ------
    InputError
        If an argument is wrong.
    MissingExtraError
        If gymnasium is not installed.
    """

    metadata: dict[str, Any] = {"render_modes": list(MODES), "render_fps": 25}  # noqa: RUF012 - as its base class

    def __init__(
        self,
        task: str = "slew",
        plant: str = "reduced",
        case: Case | str | PathLike[str] | None = None,
        actuators: Mapping[str, Any] | None = None,
        sensors: Mapping[str, Sensor] | None = None,
        coordinates: int | None = None,
        render_mode: str | None = None,
    ) -> None:
        if render_mode is not None:
            checks.one_of("render_mode", render_mode, MODES)
        self.arena = Arena(case_of(case, task), None, actuators, sensors, coordinates)
        self._loops, self.render_mode, self._screen = Loops(self.arena, plant), render_mode, Screen(render_mode)
        self._over = True
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (len(self.arena.limits),), np.float64)
        self.observation_space = gymnasium.spaces.Box(-1.0, 1.0, (self.arena.observation.size,), np.float64)

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begin an episode; ``options`` sets parameters that would be drawn, ``info`` lists all of them."""
        super().reset(seed=seed)
        self._loops.reset(0, self.np_random, options)
        self._over = False
        return self._loops.seen[0].copy(), dict(self._loops.parameters[0])

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Hold an action over one interval; ``info`` has the terms of the reward."""
        if self._over:
            raise InputError("step: expected an episode that goes on, got none or one that has ended; call reset first")
        loops = self._loops
        loops.take(action, loops.actions.shape[1:])
        loops.step()
        if self.render_mode == "human":
            self.render()
        error, rms, cost, effort, change = loops.terms[0].tolist()
        terminated, truncated = loops.terminated.item(), loops.truncated.item()
        self._over = terminated or truncated
        info = {"attitude_error": error, "surface_rms": rms, "cost": cost, "effort": effort, "change": change}
        return loops.seen[0].copy(), loops.reward.item(), terminated, truncated, info

    def render(self) -> Any:
        """Picture of the antenna on its hub, deflections enlarged: an array (height, width, 3), or on the screen."""
        return self._screen.show(self._loops, 0)

    def close(self) -> None:
        """Close the window."""
        self._screen.close()
