"""One question for every plant: what moves how, how it is integrated, and what is kept of it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, MISSING, dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError, UnsupportedError
from tautflex.mechanics.dampings.damping import Damping
from tautflex.mechanics.dampings.rayleigh import Rayleigh
from tautflex.mechanics.loads.inputs import TimeInput
from tautflex.mechanics.system import StructuralSystem
from tautflex.motion.coupling import Coupling
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import AtRest, Maneuver
from tautflex.numeric import Array
from tautflex.solvers.plausibility import doubts_about_maneuver, doubts_about_probes
from tautflex.solvers.static.prestress import PrestressedState, in_short
from tautflex.solvers.transient.adaptive import Adaptive
from tautflex.solvers.transient.explicit import ExplicitMethod
from tautflex.solvers.transient.methods.scheme import Method, check_stages
from tautflex.solvers.transient.methods.wilson import WilsonTheta
from tautflex.solvers.transient.probes import ProbeSet, place_probes
from tautflex.solvers.transient.restart.checkpoint import Checkpoint
from tautflex.solvers.transient.restart.keeper import Keeper
from tautflex.solvers.transient.status import Run
from tautflex.text import card, shown

InitialVelocity = Callable[[Array, Array], ArrayLike] | ArrayLike | None
Progress = Callable[[float, str], None] | None

# Beyond this the time axis alone would fill the memory.
_MOST_STEPS = 1e9
# Frames of pictures take so many bytes at most, however many are asked for.
MOST_FRAME_BYTES = 64e6
# Part of a step within which two instants are one.
_ON_GRID = 1e-6
# What None stands for.
_MANEUVER, _METHOD, _DAMPING, _COUPLING = AtRest(), WilsonTheta(), Rayleigh(), Coupling()
# What may stand there, and an example.
_PARTS: tuple[tuple[str, Any, Any, str], ...] = (
    ("maneuver", _MANEUVER, (Maneuver, FreeHub), "Stop(rate=0.628, duration=1.0)"),
    ("method", _METHOD, (Method, ExplicitMethod), "WilsonTheta()"),
    ("coupling", _COUPLING, Coupling, "Coupling()"),
    ("damping", _DAMPING, Damping, "Rayleigh(0.001, 0.001)"),
)


class SteppingModel(ABC):
    """A model of a prestressed state that brings its own time stepping."""

    state: PrestressedState

    @abstractmethod
    def solve(self, problem: TransientProblem, progress: Progress = None, keeper: Keeper | None = None) -> Run:
        """Answer a problem whose plant it is; a step that fails is told by the status."""


@dataclass(frozen=True, eq=False)
class TransientProblem:
    """Everything that decides a transient run, checked.

    Parameters
    ----------
    plant
        Prestressed state, or a reduced model of one (`reduce`); the run starts from its steady spinning equilibrium at
        the maneuver's start.
    maneuver
        Prescribed rigid motion, or a `FreeHub` whose motion is part of the answer; None is none.
    time_step, end_time
        Step and duration [s]; discontinuities of the maneuver are stepped onto.
    method
        Integrator; None is `WilsonTheta()`.
    adaptive
        Error control of an implicit method's steps; ``time_step`` is then the spacing of the results and the first
        trial step. None takes every step ``time_step`` long.
    damping
        `Rayleigh`, `Modal` or any other `Damping`; None is none.
    coupling
        Switches of the rotating-frame terms; None is all on.
    inputs
        A list of forces, cable tensions and film temperatures in time, see :mod:`tautflex.mechanics.loads.inputs`.
    probes
        Name -> (x, y) or (x, y, z) [m].
    probe_reading
        ``"interpolate"`` or ``"nearest-node"``.
    initial_velocity
        Function (x, y) -> transverse velocity [m/s], or array (node, 3) [m/s]; None is rest.
    initial_imperfection
        Largest displacement [m] of the start from its equilibrium, >= 0, in the shape that grows fastest from an
        unstable one, or resists least; rounding errors alone would leave an unstable equilibrium late or never.
    initial
        `Run.final` of an earlier run to go on from, at its time; ``end_time`` and maneuver keep their clock. With the
        same method and step the two runs are one that was cut, to the last bit, and share its energy balance and
        error; other ones start from its displacements and velocities alone. The first instant stored is the next one.
    every
        Store every n-th step.
    fields
        None or ``"none"``: no fields; ``"all"``: one per stored step; or times [s], rounded to steps.
    frames
        Instants at which the displacement of all nodes is kept in single precision for pictures that move: so many from
        the start to ``end_time``, evenly spaced but for the grid, 0 for none; or times [s], rounded to steps. They take
        64 MB at most: there are fewer where the mesh is larger (two at least).
    tolerance
        Newton tolerance: residual norm over the norm of the forces; None takes what the method needs, 1e-6 for most.
    max_halvings
        Times a step may be halved when Newton fails; an adaptive run goes down to its smallest step instead.
    time_error
        Whether the time error is estimated, at about 1 % of the run's cost; if not, ``run.error`` and the record's
        ``time_error`` are NaN, which is null in the JSON.

    Raises
    ------
    InputError
        If an argument is out of range.
    UnsupportedError
        If the structure could drift away as a rigid body under a maneuver.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> asked = dict(method=tf.GeneralizedAlpha(), time_step=0.01, end_time=0.5, probes={"A": (0.7, 0.4)})
    >>> run = tf.simulate(state, tf.Stop(rate=0.6, duration=0.2), **asked)
    >>> run.status.value, dict(run.data.w.sizes)
    ('completed', {'time': 51, 'probe': 1})
    """

    plant: PrestressedState | SteppingModel
    maneuver: Maneuver | FreeHub = _MANEUVER
    _: KW_ONLY
    time_step: float
    end_time: float
    method: Method | ExplicitMethod = _METHOD
    adaptive: Adaptive | None = None
    damping: Damping = _DAMPING
    coupling: Coupling = _COUPLING
    inputs: Sequence[TimeInput] = ()
    probes: Mapping[str, ArrayLike] | None = None
    probe_reading: str = "interpolate"
    initial_velocity: InitialVelocity = None
    initial_imperfection: float = 0.0
    initial: Checkpoint | None = None
    every: int = 1
    fields: str | Sequence[float] | None = None
    frames: int | Sequence[float] = 300
    tolerance: float | None = None
    max_halvings: int = 8
    time_error: bool = True

    @classmethod
    def asked(cls, plant: Any, maneuver: Any, question: Mapping[str, Any]) -> TransientProblem:
        """Problem from the keywords of a call; InputError for one that is unknown or missing."""
        keywords = {item.name: item.default for item in fields(cls) if item.kw_only}
        for name in question:
            if name not in keywords:
                raise InputError(f"{name}: expected one of the keywords {', '.join(keywords)}, got {name!r}")
        for name, default in keywords.items():
            if default is MISSING and name not in question:
                raise InputError(f"{name}: expected a number of seconds, got nothing; give {name}=...")
        return cls(plant, maneuver, **question)

    def __post_init__(self) -> None:
        if not isinstance(self.plant, PrestressedState | SteppingModel):
            raise InputError(
                f"state: expected a prestressed state or a reduced model, got {shown(self.plant)}; "
                "solve_prestress(model) gives one"
            )
        self._check_initial()
        _ = self.count
        if self.tolerance is not None:
            checks.positive("tolerance", self.tolerance)
        checks.flag("time_error", self.time_error)
        checks.whole("max_halvings", self.max_halvings, 0)
        checks.non_negative("initial_imperfection", self.initial_imperfection)
        for name, default, kind, example in _PARTS:
            if getattr(self, name) is None:
                object.__setattr__(self, name, default)
            checks.instance(name, getattr(self, name), kind, f"an object such as {example}")
        free = self.state.model.rigid_freedom
        if free and not isinstance(self.maneuver, AtRest):
            raise UnsupportedError(
                f"supports: expected a structure held against rigid motion, {free} rigid motion(s) are free; hold it "
                "where the spacecraft does (a group 'support' of a mesh file, or frame.support = 'corners'; a free "
                "hub lets that move), or study its modes instead"
            )
        example = "an object such as Adaptive(tolerance=1e-4), or None"
        checks.instance("adaptive", self.adaptive, (Adaptive, type(None)), example)
        inputs = () if self.inputs is None else self.inputs
        object.__setattr__(self, "inputs", checks.several("inputs", inputs, TimeInput, "CableTension(...)"))
        if isinstance(self.method, Method):
            check_stages(self.method)
        _ = self.placed, self.field_steps, self.frame_steps, self.velocity
        if not self.stored_steps:
            raise InputError(
                f"every: expected an instant to store between {self.start_time:g} s and end_time, got every = "
                f"{self.every}, which stores none; store more steps or run longer"
            )

    def _check_initial(self) -> None:
        """Take the state out of a run; raise InputError unless it is one of the same structure."""
        given: Any = self.initial
        if given is None:
            return
        if isinstance(given, Run):
            if given.final is None:
                raise InputError("initial: expected a run with the state that it ended in, got a run without a state")
            given = given.final
        found: Checkpoint = checks.instance(
            "initial", given, Checkpoint, "a state to go on from", remedy="give run.final"
        )
        object.__setattr__(self, "initial", found)
        if self.initial_velocity is not None or self.initial_imperfection:
            name = "initial_imperfection" if self.initial_velocity is None else "initial_velocity"
            raise InputError(f"{name}: expected none where a run goes on from initial, which has its own; leave it out")
        found.check(self.state)
        hub = self.maneuver
        if isinstance(hub, FreeHub) and found.hub.size and np.any(found.hub[7:13][hub.freedom == 0.0]):
            raise InputError(
                f"initial: expected a hub that does not move where axes = {hub.axes!r} holds it, got one with the "
                f"velocity {found.hub[7:10].tolist()} m/s and angular velocity {found.hub[10:13].tolist()} rad/s; use "
                "axes = 'free'"
            )

    def __repr__(self) -> str:
        lines = {
            "plant": in_short(self.plant) if isinstance(self.plant, PrestressedState) else shown(self.plant),
            "maneuver": shown(self.maneuver),
            "method": self.method.name,
            "steps": f"{self.count - self.begin} of {self.time_step:.6g} s to {self.end_time:.6g} s",
            "initial": "" if self.initial is None else f"{self.initial.time:.6g} s",
            "adaptive": "" if self.adaptive is None else shown(self.adaptive),
            "damping": shown(self.damping),
            "coupling": "" if self.coupling == _COUPLING else shown(self.coupling),
            "inputs": ", ".join(map(shown, self.inputs)),
            "probes": ", ".join(self.placed.names),
            "fields": len(self.field_steps) or "",
        }
        return card(self, lines)

    @property
    def state(self) -> PrestressedState:
        """The structure."""
        return self.plant if isinstance(self.plant, PrestressedState) else self.plant.state

    @cached_property
    def start_time(self) -> float:
        """Where the steps begin [s]."""
        return 0.0 if self.initial is None else self.initial.time

    @cached_property
    def begin(self) -> int:
        """Number of the grid instant that the run starts from."""
        return int(np.floor(self.start_time / self.time_step + _ON_GRID))

    @cached_property
    def shift(self) -> float:
        """Time of the grid's instant 0 [s]: a run that starts between multiples of its step shifts its grid."""
        shift = self.start_time - self.begin * self.time_step
        return shift if abs(shift) > _ON_GRID * self.time_step else 0.0

    def instant(self, number: int) -> float:
        """Time of a grid instant [s]."""
        return self.shift + number * self.time_step

    @cached_property
    def count(self) -> int:
        """Number of the last grid instant, which reaches ``end_time``."""
        step = checks.positive("time_step", self.time_step)
        if not checks.finite("end_time", self.end_time) >= self.start_time + (1.0 - _ON_GRID) * step:
            behind = "" if self.initial is None else f" behind the start at {self.start_time:g} s"
            raise InputError(f"end_time: expected at least one time_step ({step:g} s){behind}, got {self.end_time!r}")
        checks.whole("every", self.every, 1, remedy="1 stores every step")
        count = (self.end_time - self.shift) / step
        if count - self.begin > _MOST_STEPS:
            raise InputError(
                f"end_time: expected at most {_MOST_STEPS:g} steps, got {count:.3g}; run shorter or enlarge time_step"
            )
        return max(self.begin + 1, int(np.ceil(count - _ON_GRID)))

    @cached_property
    def stored_steps(self) -> range:
        """Numbers of the grid instants that are stored; where a run goes on, its start is in the earlier record."""
        first = 0 if self.initial is None else self.begin + 1
        return range(-(-first // self.every) * self.every, self.count + 1, self.every)

    @cached_property
    def placed(self) -> ProbeSet:
        """Probes on the structure."""
        return self.placed_on(self.state.system)

    def placed_on(self, system: StructuralSystem) -> ProbeSet:
        """Probes on a system of the structure, one with moved supports for example."""
        return place_probes(system, {} if self.probes is None else self.probes, self.probe_reading)

    @cached_property
    def field_steps(self) -> set[int]:
        """Steps of the grid whose whole field is stored."""
        if self.fields is None or isinstance(self.fields, str):
            checks.one_of("fields", self.fields or "none", ("none", "all"))
            return set(self.stored_steps) if self.fields == "all" else set()
        return self._steps_at("fields", self.fields)

    @cached_property
    def frame_steps(self) -> set[int]:
        """Steps of the grid that are kept as frames; a run that goes on has those of the whole one behind its start."""
        most = max(2, int(MOST_FRAME_BYTES / (12 * max(1, len(self.state.model.nodes)))))
        if isinstance(self.frames, int | np.integer):
            whole = min(checks.whole("frames", self.frames, 0), most, self.count + 1)
            steps = set(np.linspace(0, self.count, whole).round().astype(int).tolist())
        else:
            steps = self._steps_at("frames", self.frames)
            some = np.unique(np.linspace(0, len(steps) - 1, min(most, len(steps))).round().astype(int))
            steps = set(np.array(sorted(steps), dtype=int)[some].tolist())
        return {step for step in steps if step > self.begin or self.initial is None}

    def _steps_at(self, name: str, times: Any) -> set[int]:
        """Steps of the grid nearest to times [s], without that at which an earlier run ended."""
        step, start, end = self.time_step, self.start_time, self.instant(self.count)
        steps = set()
        for time in checks.float_array(name, times, (None,)):
            if not start <= time <= end + 0.5 * step:
                raise InputError(f"{name}: expected times in [{start:g}, {end:g}] s, got {time:g}")
            steps.add(round((time - self.shift) / step))
        return steps if self.initial is None else steps - {self.begin}

    @cached_property
    def velocity(self) -> Array:
        """Velocities of the free unknowns at the start, shape (size,); rotations of beam nodes start at rest."""
        model, given = self.state.model, self.initial_velocity
        if given is None:
            return np.zeros(self.state.system.size)
        values: Any = given
        if callable(given):
            checks.function("initial_velocity", given, "x", "y")
            x, y = model.nodes[:, 0], model.nodes[:, 1]
            values = np.zeros((len(model.nodes), 3))
            try:
                values[:, 2] = np.broadcast_to(np.asarray(given(x, y), dtype=float), x.shape)
            except (TypeError, ValueError, OverflowError) as error:
                raise InputError(
                    f"initial_velocity: expected a function (x, y) -> velocity of shape {x.shape}, got {error}"
                ) from None
        values = checks.float_array("initial_velocity", values, (len(model.nodes), 3))
        full = np.zeros(model.dof_count)
        full[model.translation_dofs] = values
        return full[model.free_dofs]

    @property
    def doubts(self) -> list[str]:
        """What of the question is hardly meant, in words."""
        step, found = self.time_step if self.adaptive is None else None, list[str]()
        if isinstance(self.maneuver, Maneuver):
            found = doubts_about_maneuver(self.maneuver, step, self.end_time)
        if self.probes and self.probe_reading == "nearest-node":
            found += doubts_about_probes(self.state.model, self.probes, self.placed.positions)
        return found

    @property
    def attributes(self) -> dict[str, Any]:
        """What a result says about its question."""
        last = self.maneuver.end if isinstance(self.maneuver, Maneuver) else 0.0
        return {
            **({"maneuver_end": last} if last > 0.0 else {}),
            **({"adaptive": repr(self.adaptive)} if self.adaptive is not None else {}),
            "title": "rigid-flexible response of a tensioned membrane structure",
            "method": self.method.name,
            "maneuver": repr(self.maneuver),
            "damping": repr(self.damping),
            "coupling": repr(self.coupling),
            "time_step": self.time_step,
            **({} if self.initial is None else {"resumed_from": self.start_time}),
        }

    @property
    def memory_of(self) -> dict[str, str]:
        """What the memory of a run belongs to, see `Checkpoint`."""
        hub, method, step = self.maneuver, self.method, self.time_step
        found = {"plant": type(self.plant).__name__, "method": repr(method), "time_step": repr(float(step))}
        if self.adaptive is not None:
            found["adaptive"] = repr(self.adaptive)
        if self.tolerance is not None:
            found["tolerance"] = repr(float(self.tolerance))
        if self.shift:
            found["grid"] = f"shifted by {self.shift!r} s"
        if isinstance(hub, FreeHub):
            found["hub"] = repr([float(hub.mass), hub.tensor.tolist(), [float(x) for x in hub.center], hub.axes])
        return found
