"""A law closes the loop around a plant."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.control.law import ControlLaw, law_of
from tautflex.control.plant import Plant, PlantState
from tautflex.control.runs.following import references, spec_of
from tautflex.control.sensors.sensor import hub_rows
from tautflex.control.signals import Reference, labels_of, units_of
from tautflex.errors import InputError, NotConvergedError
from tautflex.interrupts import deferred, meet
from tautflex.motion.attitude import attitude
from tautflex.motion.kinematics import Maneuver
from tautflex.numeric import Array
from tautflex.solvers.remembering import flat, nested
from tautflex.solvers.transient.status import Run, Status
from tautflex.solvers.variables import LOOP, described


def close_loop(
    plant: Plant,
    law: ControlLaw | Callable[[float, Array], ArrayLike],
    maneuver: Maneuver | None = None,
    end_time: float = 10.0,
    seed: int = 0,
    progress: Callable[[float, str], None] | None = None,
    frames: int = 300,
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
    progress
        Called with the fraction done and a short message; KeyboardInterrupt raised in it ends the run.
    frames
        Samples at which displacements are kept for pictures that move, evenly spaced, see `TransientProblem`.

    Returns
    -------
    Run
        Its data also has, at ``sample_time``, ``measurement``, ``command`` (as asked for), ``reference``,
        ``attitude_error`` [rad] of a free hub, and ``source_work`` of every actuator since the start [J].

    Raises
    ------
    InputError
        If an argument is wrong, or the loop has not what the law needs.
    NotConvergedError
        If a step fails, or the law does: raises, or commands what is no finite number. ``.result`` is the run until
        then.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> rom = tf.reduce(state, tf.ModalBasis(directions=("rx",)))
    >>> hub = tf.FreeHub(mass=50.0, inertia=(5.0, 5.0, 8.0), axes="x")
    >>> actuators, damping = {"torque": tf.HubTorque("x", limit=6.0)}, tf.Rayleigh(0.001, 0.001)
    >>> sensors = {"attitude": tf.Attitude(), "rate": tf.Rate()}
    >>> plant = tf.Plant(rom, hub, actuators, sensors, interval=0.02, damping=damping)
    >>> law = tf.PD(stiffness=30.0, damping=22.0, inertia=7.46)
    >>> run = tf.close_loop(plant, law, tf.Slew(angle=0.5, duration=1.0, profile="bang-bang"), end_time=2.0)
    >>> run.status.value, run.data.command.sizes["sample_time"]
    ('completed', 101)
    """
    return kept_loop(plant, law, maneuver, end_time, seed, progress, frames)


@deferred()
def kept_loop(
    plant: Plant,
    law: ControlLaw | Callable[[float, Array], ArrayLike],
    maneuver: Maneuver | None,
    end_time: float,
    seed: int,
    progress: Callable[[float, str], None] | None,
    frames: int,
    keeper: LoopKeeper | None = None,
) -> Run:
    """`close_loop`, which a keeper keeps while it is under way, and may have kept before."""
    checks.instance("plant", plant, Plant, "a plant", remedy="Plant(state, ...) makes one")
    asked, tell = law_of("law", law), checks.teller(progress)
    count = max(1, int(np.ceil(checks.positive("end_time", end_time) / plant.interval - 1e-6)))
    kept = np.linspace(0, count, min(checks.whole("frames", frames, 0), count + 1)).round()
    options: dict[str, Any] = {"frames": plant.interval * kept}
    options |= {} if maneuver is None else {"maneuver": maneuver}
    measured = [plant.reset(seed, options)]
    times = np.asarray(plant.interval * np.arange(count + 1), dtype=np.float64)
    follow = references(plant.maneuver, times, plant.hub)
    memory, remarks = start_law(plant, asked)
    commands, work, status = list[Array](), [plant.energy_by_source], Status.COMPLETED
    if keeper is not None and keeper.kept is not None:
        memory, measured, commands, work = _go_on(keeper, plant, (asked, memory), follow, options)
    try:
        for number, reference in enumerate(follow[len(commands) : -1], len(commands)):
            meet()
            if keeper is not None and keeper.due():
                _keep(keeper, plant, measured, commands, work)
            time = reference.time
            try:
                memory, given = asked.act(memory, measured[-1].copy(), reference)
                command = checks.float_array("command", given, (sum(each.size for each in plant.inputs),))
            except Exception as error:
                said = f"t = {time:.6g} s: the law failed ({type(error).__name__}: {error}); correct it"
                raise NotConvergedError(said, result=plant.result(Status.NOT_CONVERGED)) from error
            measured.append(plant.step(command))
            commands.append(command)
            work.append(plant.energy_by_source)
            if number % max(1, count // 100) == 0:
                tell((number + 1) / count, f"t = {plant.time:.3g} s")
    except KeyboardInterrupt:
        status = Status.INTERRUPTED
    except NotConvergedError as error:
        if isinstance(error.result, Run):
            error.result = _with_loop(error.result, plant, times, measured, commands, work, follow, remarks)
        raise
    return _with_loop(plant.result(status), plant, times, measured, commands, work, follow, remarks)


class LoopKeeper(Protocol):
    """Keeps a closed loop outside the memory that dies with its process.

    Attributes
    ----------
    kept
        Memory of the loop that shall go on, as `keep_loop` got it; None: it starts.
    """

    kept: Mapping[str, Array] | None

    @property
    def runs(self) -> list[Run]:
        """Runs of the plant that `keep_loop` got."""

    def due(self) -> bool:
        """Whether it is time to keep the loop again; asked between its intervals."""

    def keep_loop(self, time: float, runs: Sequence[Run], memory: Mapping[str, Array]) -> None:
        """Keep the finished runs of the plant, and where the loop stands at an instant [s]."""


def _keep(
    keeper: LoopKeeper, plant: Plant, measured: list[Array], commands: list[Array], work: list[dict[str, float]]
) -> None:
    """Keep a loop whose plant begins a run here: only then is its record whole, and the same as if it were not kept."""
    runs, time = plant.cut(), plant.time
    if runs and runs[-1].reached == time:
        state, spent = plant.state, [list(each.values()) for each in work]
        through = {"measured": np.array(measured), "commands": np.array(commands), "work": np.array(spent)}
        parts = {name: getattr(state, name) for name in ("intervals", "actuators", "sensors", "measurement")}
        keeper.keep_loop(time, runs, flat(through | parts))


def _go_on(
    keeper: LoopKeeper, plant: Plant, law: tuple[ControlLaw, Any], follow: list[Reference], options: dict[str, Any]
) -> tuple[Any, list[Array], list[Array], list[dict[str, float]]]:
    """Memory of the law, measurements, commands and work of a loop that goes on; the plant is where it was."""
    assert keeper.kept is not None
    (asked, memory), kept, runs = law, nested(keeper.kept), keeper.runs
    motion = runs[-1].final
    assert motion is not None
    drives, sensors = kept.get("actuators", {}), kept.get("sensors", {})
    state = PlantState(motion, kept["intervals"], drives, sensors, kept["measurement"])
    plant.reset(0, options | {"state": state, "runs": runs})
    for measurement, reference, command in zip(kept["measured"], follow, kept["commands"], strict=False):
        memory, given = asked.act(memory, measurement.copy(), reference)  # a law has no other way to its memory
        if not np.array_equal(np.ravel(given), command):
            text = f"t = {reference.time:.6g} s: expected the law to command what it did before the loop was kept"
            raise InputError(f"{text}, got other numbers; start anew with --force")
    names = list(plant.energy_by_source)
    work = [dict(zip(names, row, strict=True)) for row in kept["work"].tolist()]
    return memory, list(kept["measured"]), list(kept["commands"]), work


def start_law(plant: Plant, law: ControlLaw) -> tuple[Any, list[str]]:
    """Memory of a law before the first measurement of a plant, and what it and the plant say about the loop.

    The plant is linearized where the law asks for its model.

    Raises
    ------
    InputError
        If the loop has not what the law needs.
    """
    spec = spec_of(plant, law)
    return law.start(spec), [*plant.remarks, *spec.remarks]


def _with_loop(
    run: Run,
    plant: Plant,
    times: Array,
    measured: list[Array],
    commands: list[Array],
    work: list[dict[str, float]],
    follow: list[Reference],
    remarks: list[str],
) -> Run:
    """The run with what went through the loop; the last sample has no command yet (NaN)."""
    count = len(work)
    given = np.full((count, sum(each.size for each in plant.inputs)), np.nan)
    given[: len(commands)] = np.reshape(commands, (len(commands), given.shape[1]))
    arrays = {
        "measurement": np.array(measured[:count]).reshape(count, -1),
        "command": given,
        "reference": np.array([each.numbers for each in follow[:count]]).reshape(count, 3, -1),
        "source_work": np.array([list(each.values()) for each in work]).reshape(count, -1),
    }
    labels = {"output": list(labels_of(plant.outputs)), "input": list(labels_of(plant.inputs)), "source": list(work[0])}
    if plant.hub is not None:
        arrays["attitude_error"] = _attitude_error(run.data, plant.maneuver, times[:count])
        labels["axis"] = ["xyz"[int(row.argmax())] for row in hub_rows(plant.hub)]
    said = [*run.data.attrs["warnings"], *remarks]
    data = (
        run.data.assign_attrs(warnings=said)
        .assign(described(LOOP, arrays))
        .assign_coords(
            described(LOOP, {"sample_time": times[:count]}) | labels | {"asked": ["attitude", "rate", "acceleration"]}
        )
    )
    data["measurement"].attrs["channel_units"] = list(units_of(plant.outputs))
    data["command"].attrs["channel_units"] = list(units_of(plant.inputs))
    if plant.hub is not None and 0.0 < plant.maneuver.end < np.inf:
        data.attrs["maneuver_end"] = plant.maneuver.end  # of what the hub was to follow
    return replace(run, data=data)


def _attitude_error(data: xr.Dataset, maneuver: Maneuver, times: Array) -> Array:
    """Angle between a hub and what it was to follow [rad], shape (time,)."""
    turned = data["attitude"].sel(time=times, method="nearest").values
    wanted = attitude(maneuver, times)
    # |product of the one's conjugate and the other|, as sine and cosine of half the angle
    sine = np.linalg.norm(
        wanted[:, :1] * turned[:, 1:] - turned[:, :1] * wanted[:, 1:] - np.cross(wanted[:, 1:], turned[:, 1:]), axis=1
    )
    return np.asarray(2.0 * np.arctan2(sine, np.abs(np.sum(wanted * turned, axis=1))))
