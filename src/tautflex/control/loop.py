"""A law closes the loop around a plant."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.control.law import ControlLaw, law_of
from tautflex.control.plant import Plant
from tautflex.control.sensors.sensor import hub_rows
from tautflex.control.signals import LoopSpec, Reference, labels_of, units_of
from tautflex.errors import InputError, NotConvergedError
from tautflex.motion.attitude import attitude
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import Maneuver
from tautflex.motion.rotations import rotation_vector
from tautflex.numeric import Array
from tautflex.solvers.transient.status import Run
from tautflex.solvers.variables import LOOP, described


def close_loop(
    plant: Plant,
    law: ControlLaw | Callable[[float, Array], ArrayLike],
    maneuver: Maneuver | None = None,
    end_time: float = 10.0,
    seed: int = 0,
) -> Run:
    """Run a plant under a law.

    Parameters
    ----------
    plant
        The plant, which is reset.
    law
        Control law, or a function (time [s], measurement) -> command, asked once per interval.
    maneuver
        What the hub is to follow, or the motion that is prescribed; None is the plant's own.
    end_time
        Duration [s].
    seed
        Of the sensors' noise.

    Returns
    -------
    Run
        Its data also has ``measurement``, ``command`` (as asked for) and ``reference`` at ``sample_time``.

    Raises
    ------
    InputError
        If an argument is wrong, or the loop has not what the law needs.
    NotConvergedError
        If a step fails, or the law does: raises, or commands what is no finite number. ``.result`` is the run until
        then.
    """
    checks.instance("plant", plant, Plant, "a plant", remedy="Plant(state, ...) makes one")
    asked = law_of("law", law)
    count = int(np.ceil(checks.positive("end_time", end_time) / plant.interval - 1e-6))
    measured = [plant.reset(seed, None if maneuver is None else {"maneuver": maneuver})]
    times = np.asarray(plant.interval * np.arange(count + 1), dtype=np.float64)
    follow = references(plant.maneuver, times, plant.hub)
    spec = LoopSpec(plant.outputs, plant.inputs, plant.interval, len(follow[0].rate))
    try:
        memory = asked.start(spec)
    except InputError as error:
        if not str(error).startswith("model:"):
            raise
        memory = asked.start(replace(spec, model=plant.linearize()))
    commands: list[Array] = []
    try:
        for reference in follow[:-1]:
            time = reference.time
            try:
                memory, given = asked.act(memory, measured[-1].copy(), reference)
                command = checks.float_array("command", given, (sum(each.size for each in plant.inputs),))
            except Exception as error:
                said = f"t = {time:.6g} s: the law failed ({type(error).__name__}: {error}); correct it"
                raise NotConvergedError(said, result=plant.run) from error
            measured.append(plant.step(command))
            commands.append(command)
    except NotConvergedError as error:
        if isinstance(error.result, Run):
            error.result = _with_loop(error.result, plant, times, measured, commands, follow)
        raise
    return _with_loop(plant.run, plant, times, measured, commands, follow)


def references(maneuver: Maneuver, times: Array, hub: FreeHub | None) -> list[Reference]:
    """What a maneuver asks of a hub's axes at rising instants [s]; of none where there is no hub."""
    if hub is None:
        return [Reference.rest(float(time), 0) for time in times]
    rows, segments, found = hub_rows(hub), maneuver.segments(), list[Reference]()
    for time, quaternion in zip(times.tolist(), attitude(maneuver, times), strict=True):
        motion = next(s for s in reversed(segments) if s.start <= time + 1e-9).motion(time)
        parts = rotation_vector(quaternion), motion.angular_velocity, motion.angular_acceleration
        found.append(Reference(time, *(rows @ part for part in parts)))
    return found


def _with_loop(
    run: Run, plant: Plant, times: Array, measured: list[Array], commands: list[Array], follow: list[Reference]
) -> Run:
    """The run with what went through the loop; the last sample has no command yet (NaN)."""
    count = len(measured)
    given = np.full((count, sum(each.size for each in plant.inputs)), np.nan)
    given[: len(commands)] = np.reshape(commands, (len(commands), -1))
    arrays = {
        "measurement": np.array(measured).reshape(count, -1),
        "command": given,
        "reference": np.array([each.numbers for each in follow[:count]]).reshape(count, 3, -1),
    }
    labels = {"output": list(labels_of(plant.outputs)), "input": list(labels_of(plant.inputs))}
    data = run.data.assign(described(LOOP, arrays)).assign_coords(
        described(LOOP, {"sample_time": times[:count]}) | labels | {"asked": ["attitude", "rate", "acceleration"]}
    )
    data["measurement"].attrs["channel_units"] = list(units_of(plant.outputs))
    data["command"].attrs["channel_units"] = list(units_of(plant.inputs))
    return replace(run, data=data)
