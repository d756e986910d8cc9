"""One way from a case to its closed loop: plant and law, run, and written to files."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from tautflex import checks
from tautflex.analysis.record import counted_from
from tautflex.case import build
from tautflex.case.options import by_keys, within
from tautflex.case.prepared import reduced_model
from tautflex.case.run import (
    CHECKPOINT,
    Figures,
    Progress,
    labelled,
    owner_of,
    prestressed,
    read_settling,
    read_surface,
    with_trouble,
    write_results,
)
from tautflex.case.schema import Case
from tautflex.control.actuators.actuator import Actuator
from tautflex.control.actuators.hub_torque import HubTorque
from tautflex.control.authority import authority
from tautflex.control.law import ControlLaw, added
from tautflex.control.loop import kept_loop, start_law
from tautflex.control.plant import Plant
from tautflex.control.sensors.sensor import Sensor
from tautflex.errors import CaseError, NotConvergedError
from tautflex.files.checkpoints import FOLDER, LoopFolder, run_folder
from tautflex.files.transaction import result_file
from tautflex.interrupts import deferred
from tautflex.motion.hub import FreeHub
from tautflex.reduction.polynomial.model import ReducedModel
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.status import Run, Status


def build_sensors(case: Case, state: PrestressedState, hub: FreeHub | None) -> dict[str, Sensor]:
    """Build the sensors of a case for its structure; CaseError if one does not fit."""
    found = dict[str, Sensor]()
    for name, given in case.sensors.items():
        with within(f"sensors.{name}"):
            found[name] = given.placed(state.model)
            found[name].prepare(state, hub)
    return found


def build_plant(case: Case, state: PrestressedState, reduced: ReducedModel | None = None) -> Plant:
    """Build the plant of a case: its structure, or a reduced model of it, on its hub, with actuators and sensors.

    A reduced model that is known already, see `prepare`, is not made again.

    Raises
    ------
    InputError
        If a part does not fit the structure, or the loop.
    """
    hub = None if case.hub is None else case.hub.build()
    actuators, inputs = build.build_actuators(case, state), build.build_inputs(case, state)
    effects = [drive.effect for drive in actuators.values() if isinstance(drive, Actuator)]
    if reduced is None:
        reduced = reduced_model(case, state, [*inputs, *effects])
    return Plant(
        reduced or state,
        hub,
        actuators,
        build_sensors(case, state, hub),
        interval=case.loop.interval,
        time_step=case.solver.time_step,
        method=case.solver.build(),
        damping=build.build_damping(case, state),
        maneuver=build.build_maneuver(case),
        inputs=inputs,
        probes=case.output.probes,
    )


def build_law(case: Case, plant: Plant) -> ControlLaw:
    """Build the law of a case, tried on its plant, see `tried_law`."""
    return tried_law(case, plant)[0]


def tried_law(case: Case, plant: Plant) -> tuple[ControlLaw, list[str]]:
    """Law of a case, tried on its plant, and what it says about the loop.

    Raises
    ------
    InputError
        If there is none, or the plant has not what it needs.
    """
    if case.controller is None:
        text = "controller: missing, expected a [controller] section with kind = 'pd' or another law"
        raise CaseError(f"{text}; add it, `tautflex init --template control` writes a case with one")
    several = case.controller if isinstance(case.controller, tuple) else (case.controller,)

    def started(number: int) -> tuple[ControlLaw, list[str]]:
        with within("controller" if several[0] is case.controller else f"controller.{number}"):
            law = several[number].build()
            return law, start_law(plant, law)[1]

    laws = checks.together(*(partial(started, number) for number in range(len(several))))
    law = laws[0][0] if len(laws) == 1 else added(*(law for law, _ in laws))
    return law, list(dict.fromkeys(text for _, said in laws for text in said))


def check_loop(case: Case, state: PrestressedState) -> list[str]:
    """What the law of a case says about its loop.

    Raises
    ------
    InputError
        Unless what the case has of a loop fits its structure, and the law what it reads and commands.
    """
    if case.controller is not None:
        plant = build_plant(case, state)
        said = tried_law(case, plant)[1]
        with by_keys():
            plant.reset()
        return said
    hub = None if case.hub is None else case.hub.build()
    build.build_actuators(case, state)
    build_sensors(case, state, hub)
    return []


def authority_of_case(case: Case, modes: int = 10) -> xr.Dataset:
    """What the actuators of a case at their limits can do to its lowest modes, see `authority`.

    Raises
    ------
    InputError
        If the case cannot be built, or has no actuator that acts on the structure.
    """
    maneuver, state = prestressed(case, checks.teller(None))
    effects, limits = dict[str, Any](), dict[str, Any]()
    for name, drive in build.build_actuators(case, state).items():
        if isinstance(drive, Actuator):
            effects[name] = drive.effect.prepare(state.system)
            limits |= {} if drive.limit is None else {name: drive.limit}
    if not effects:
        text = "actuators: expected at least one that acts on the structure, got none"
        raise CaseError(f"{text}; add for example [actuators.tension] with kind = 'tension-group'")
    motion = None if case.hub is not None else maneuver.start()
    return authority(state, effects, limits=limits, motion=motion, modes=modes)


def control_case(
    case: Case,
    progress: Progress | None = None,
    *,
    checkpoint: str | os.PathLike[str] | None = None,
    seconds: float = CHECKPOINT,
) -> Run:
    """Run the closed loop of a case: what `tautflex control` does, without files and with the same numbers.

    Parameters
    ----------
    case
        Validated case with a [controller].
    progress
        Called with the fraction done (0 to 1) and a short message; KeyboardInterrupt raised in it ends the run.
    checkpoint, seconds
        As for `run_case`; a loop is kept at ends of stretches of 1024 intervals alone.

    Returns
    -------
    Run

    Raises
    ------
    InputError
        If the case cannot be built, its loop has not what the law needs, or the checkpoint is that of another one.
    NotConvergedError
        If a step or the law fails; ``.result`` is the run until then.

    Examples
    --------
    >>> import tautflex as tf
    >>> run = tf.control_case(tf.load_case("slew.toml", ["solver.end_time=0.1"]))
    >>> run.status.value
    'completed'
    """
    checks.instance("case", case, Case, "a case", remedy="load_case('slew.toml') gives one")
    checks.positive("seconds", seconds)
    tell, place = checks.teller(progress), None if checkpoint is None else checks.path("checkpoint", checkpoint)
    plant, law = build_loop(case, prestressed(case, tell)[1], tell)
    if place is None:
        return close_case(case, plant, law, tell)
    with (
        result_file(place, "checkpoint"),
        run_folder(LoopFolder, place, owner_of(case), seconds, resume=True) as keeper,
    ):
        run = close_case(case, plant, law, tell, keeper)
        if run.status is not Status.INTERRUPTED:
            keeper.remove()
        return run


def build_loop(
    case: Case, state: PrestressedState, progress: Progress, reduced: ReducedModel | None = None
) -> tuple[Plant, ControlLaw]:
    """Plant of a case, on a reduced model that is known already if one is given, and its law."""
    progress(0.0, "plant and law")
    plant = build_plant(case, state, reduced)
    return plant, build_law(case, plant)


def close_case(case: Case, plant: Plant, law: ControlLaw, progress: Progress, keeper: LoopFolder | None = None) -> Run:
    """Run the closed loop of a case on its plant under its law, which a folder may keep."""
    try:
        asked = case.solver.end_time, case.loop.seed, progress, case.output.frames
        with by_keys():
            run = _labelled(case, kept_loop(plant, law, None, *asked, keeper))
        return run if keeper is None else with_trouble(run, keeper)
    except NotConvergedError as error:
        if isinstance(error.result, Run):
            error.result = _labelled(case, error.result)
        raise


def _labelled(case: Case, run: Run) -> Run:
    run = labelled(case, run)
    return replace(run, data=run.data.assign_attrs(attitude_tolerance=case.output.attitude_tolerance))


def write_case_loop(
    case: Case,
    directory: Path,
    progress: Progress | None = None,
    *,
    figures: Figures | None = None,
    title: str = "tautflex control",
    seconds: float = CHECKPOINT,
    resume: bool = False,
) -> dict[str, Any]:
    """Run the closed loop of a case and write it as `write_case_run` does.

    Returns
    -------
    dict
        The content of ``summary.json``: that of a run, ``settling_time`` after the maneuver [s] of ``surface`` and,
        where the law turns a hub, of ``attitude``, None where they do not settle, and ``energy_by_source`` [J].
    """
    tell = checks.teller(progress)
    _, state = prestressed(case, tell)
    plant, law = build_loop(case, state, tell)
    with deferred(), run_folder(LoopFolder, directory / FOLDER, owner_of(case), seconds, resume) as keeper:
        more: dict[str, Any] = {"resumed_from": keeper.resumed_from}
        try:
            run = close_case(case, plant, law, tell, keeper)
        except NotConvergedError as error:
            if not isinstance(error.result, Run):
                raise
            run, more["message"] = error.result, str(error)
        found = write_results(case, state, run, directory, tell, figures, title, more | loop_summary(case, run))
        if run.status is not Status.INTERRUPTED:
            keeper.remove()
        return found


def _turned(case: Case, data: xr.Dataset) -> bool:
    """Whether the law has commanded a torque on the hub, so that its attitude is its affair."""
    torques = {name for name, own in case.actuators.items() if issubclass(own.made_from or Actuator, HubTorque)}
    labels = [str(label).partition("[")[0] in torques for label in data["input"].values]
    return bool(np.nan_to_num(data["command"].transpose("input", ...).values[labels]).any())


def loop_summary(case: Case, run: Run) -> dict[str, Any]:
    """What ``summary.json`` says of a closed loop beside `summary_of` its run."""
    data, end = run.data, counted_from(run)
    settled: dict[str, float | None] = {}
    if "attitude_error" in data:
        off = data["attitude_error"].rename(sample_time="time")
        found = read_settling(off, case.output.attitude_tolerance, end)
        if found is not None or _turned(case, data):
            settled["attitude"] = found
    settled["surface"] = read_surface(data, end, case.output.surface_tolerance)["settling_time"]
    return {"settling_time": settled, "energy_by_source": json.loads(data.attrs["energy_by_source"])}
