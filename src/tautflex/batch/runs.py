"""Many runs at once: the public face of the room."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from tautflex import checks
from tautflex.batch.chunks import ChunkRunner, usual_chunk
from tautflex.batch.equations.equation import STORED, EachRun, Plant
from tautflex.batch.equations.full import FullPlant
from tautflex.batch.equations.rate_history import Course, Numbers, course_of
from tautflex.batch.equations.reduced import ReducedPlant
from tautflex.batch.library import jax
from tautflex.batch.output.dataset import to_dataset
from tautflex.batch.output.response import Response, Walk, response_function
from tautflex.batch.parameters import check_names, checked_numbers
from tautflex.batch.steps.explicit import ExplicitWalk
from tautflex.batch.steps.implicit import ImplicitWalk
from tautflex.errors import InputError, NotConvergedError, UnsupportedError
from tautflex.mechanics.dampings.rayleigh import Rayleigh
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import AtRest, Maneuver
from tautflex.reduction.polynomial.model import ReducedModel
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.explicit import CentralDifference
from tautflex.solvers.transient.methods.scheme import ImplicitMethod
from tautflex.solvers.transient.methods.wilson import WilsonTheta
from tautflex.solvers.transient.probes import ProbeSet, place_probes
from tautflex.solvers.transient.problem import InitialVelocity, check_parts, start_velocity, step_count
from tautflex.solvers.transient.status import Status


class Batch:
    """Runs of one structure with other tensions, moduli, densities, damping and maneuvers, all at once.

    Parameters
    ----------
    plant
        Prestressed state (the full model), or a reduced model of it.

    Raises
    ------
    InputError
        If ``plant`` is neither.
    UnsupportedError
        If its laws are not elastic, it can drift away, or it is too large.
    MissingExtraError
        If JAX is not installed (when the name is first used).
    """

    def __init__(self, plant: PrestressedState | ReducedModel) -> None:
        if not isinstance(plant, PrestressedState | ReducedModel):
            raise InputError(f"plant: expected a prestressed state or a reduced model, got {plant!r}")
        self._plant: Plant = ReducedPlant(plant) if isinstance(plant, ReducedModel) else FullPlant(plant)
        self._state = self._plant.state
        self._run = ChunkRunner(self._plant.side_by_side)

    def response(
        self,
        maneuver: Maneuver | None = None,
        *,
        method: ImplicitMethod | CentralDifference | None = None,
        time_step: float,
        end_time: float,
        damping: Rayleigh | None = None,
        coupling: Coupling | None = None,
        probes: Mapping[str, ArrayLike] | None = None,
        probe_reading: str = "interpolate",
        initial_velocity: InitialVelocity = None,
        store: Sequence[str] = STORED,
        tolerance: float | None = None,
    ) -> Callable[[Mapping[str, Any]], Response]:
        """One run as a pure function of its parameters, for `jax.grad`, `jax.jit` and `jax.vmap`.

        Parameters
        ----------
        maneuver, method, time_step, end_time, damping, coupling, probes, probe_reading, initial_velocity, tolerance
            As for `tautflex.simulate`.
        store
            What the record holds, of ``"displacement"``, ``"velocity"`` and ``"energy"``.

        Returns
        -------
        callable
            Mapping of parameters, see `simulate`, to a `Response`; what it leaves out is as in the arguments. Where
            parameters have a row per run, so has everything in the response (faster than `jax.vmap`).

        Raises
        ------
        InputError
            If an argument is out of range.
        UnsupportedError
            If the maneuver or the method has no batched form.
        """
        course, defaults, function = self._function(
            maneuver,
            method,
            time_step,
            end_time,
            damping,
            coupling,
            probes,
            probe_reading,
            initial_velocity,
            store,
            tolerance,
        )[:3]

        def respond(parameters: Mapping[str, Any]) -> Response:
            check_names(parameters, self._plant.kinds, course)
            numbers = {**defaults, **parameters}
            differ = frozenset(name for name in parameters if np.ndim(numbers[name]) > np.ndim(defaults.get(name, 0.0)))
            if differ:
                return self._run.many(function, differ, len(numbers[min(differ)]))(numbers)
            if not self._plant.side_by_side:
                return function(numbers, EachRun())
            return jax.tree.map(lambda part: part[..., 0], function(numbers, EachRun(1)))

        return respond

    def simulate(
        self,
        parameters: Mapping[str, ArrayLike],
        maneuver: Maneuver | None = None,
        *,
        method: ImplicitMethod | CentralDifference | None = None,
        time_step: float,
        end_time: float,
        damping: Rayleigh | None = None,
        coupling: Coupling | None = None,
        probes: Mapping[str, ArrayLike] | None = None,
        probe_reading: str = "interpolate",
        initial_velocity: InitialVelocity = None,
        store: Sequence[str] = STORED,
        tolerance: float | None = None,
        chunk: int | None = None,
        throw: bool = True,
    ) -> xr.Dataset:
        """Runs with given parameters.

        Parameters
        ----------
        parameters
            Name -> one value per run, or one for all: ``"tension_x"``, ``"tension_y"``, ``"youngs_modulus.membrane"``
            (``.cable``, ``.beam``) and ``"density.membrane"`` are factors of the state; ``"damping.alpha"``,
            ``"damping.beta"`` and the maneuver's own numbers, such as ``"maneuver.rate"``, replace those of the
            arguments.
        maneuver, method, time_step, end_time, damping, coupling, probes, probe_reading, initial_velocity, tolerance
            As for `tautflex.simulate`.
        store
            What the result holds, of ``"displacement"``, ``"velocity"`` and ``"energy"``.
        chunk
            Runs computed side by side; None takes what suits a processor.
        throw
            Raise when a run fails; False returns all, failed ones labelled and NaN from where they failed.

        Returns
        -------
        xarray.Dataset
            Variables of `tautflex.simulate` with a dimension ``run``, and ``status`` of each run.

        Raises
        ------
        InputError
            If a parameter or an argument is out of range.
        UnsupportedError
            If the maneuver or the method has no batched form.
        NotConvergedError
            If a run fails and ``throw`` is set; ``.result`` holds all runs.
        """
        maneuver = maneuver or AtRest()
        course, defaults, function, placed, key = self._function(
            maneuver,
            method,
            time_step,
            end_time,
            damping,
            coupling,
            probes,
            probe_reading,
            initial_velocity,
            store,
            tolerance,
        )
        arrays, axes, runs = checked_numbers(parameters, self._plant.kinds, course)
        _check_maneuvers(maneuver, arrays, axes, runs)
        numbers = {**{name: np.asarray(value, dtype=float) for name, value in defaults.items()}, **arrays}
        differ = frozenset(name for name, axis in axes.items() if axis == 0)
        usual = usual_chunk(runs, self._plant.side_by_side)
        at_once = min(runs, usual if chunk is None else checks.whole("chunk", chunk, 1))
        record = self._run(function, key, numbers, differ, runs, at_once)
        data = to_dataset(record, arrays, axes, runs, placed, method or WilsonTheta(), maneuver, time_step)
        failed = int(np.sum(data["status"].values != Status.COMPLETED.value))
        if failed and throw:
            raise NotConvergedError(f"{failed} of {runs} runs: {Status.NOT_CONVERGED.message}", result=data)
        return data

    def _function(
        self,
        maneuver: Maneuver | None,
        method: ImplicitMethod | CentralDifference | None,
        time_step: float,
        end_time: float,
        damping: Rayleigh | None,
        coupling: Coupling | None,
        probes: Mapping[str, ArrayLike] | None,
        probe_reading: str,
        initial_velocity: InitialVelocity,
        store: Sequence[str],
        tolerance: float | None,
    ) -> tuple[Course, Numbers, Callable[[Numbers, EachRun], Response], ProbeSet, Hashable]:
        """Course, default numbers, the run as a function of all numbers, probes, and the key of its compilation."""
        count = step_count(time_step, end_time, 1)
        maneuver, method = maneuver or AtRest(), method or WilsonTheta()
        damping, coupling = damping or Rayleigh(), coupling or Coupling()
        check_parts(maneuver, method, coupling, damping, None)
        make, wanted = self._walks(method, time_step, tolerance)
        for name in store:
            checks.one_of("store", name, STORED)
        course = course_of(maneuver)
        placed = place_probes(self._state.system, probes or {}, probe_reading)
        velocity = start_velocity(self._state, initial_velocity)
        if isinstance(self._plant, ReducedPlant):
            velocity = self._plant.rom.coordinates(velocity)

        function = response_function(
            self._plant, course, coupling, placed, time_step, count, velocity, tuple(store), make
        )
        defaults = {
            "damping.alpha": damping.alpha,
            "damping.beta": damping.beta,
            **{f"maneuver.{name}": value for name, value in course.numbers.items()},
        }
        key = (
            course.key,
            course.axis,
            course.origin,
            coupling,
            method,
            placed.map.toarray().tobytes(),
            velocity.tobytes(),
            (time_step, count, wanted),
            tuple(store),
        )
        return course, defaults, function, placed, key

    def _walks(
        self, method: ImplicitMethod | CentralDifference, time_step: float, tolerance: float | None
    ) -> tuple[Callable[[Any], Walk], float]:
        """What makes the steps of an equation, and the tolerance they meet."""
        wanted = 1.0 if tolerance is None else checks.positive("tolerance", tolerance)
        if isinstance(method, CentralDifference):
            if not self._plant.side_by_side:
                raise UnsupportedError(
                    "method: expected an implicit method for the full model in a batch, got CentralDifference(), whose "
                    "stable step is thousands of times smaller; Batch(reduce(state)) takes it"
                )
            return (lambda equation: ExplicitWalk(equation, time_step)), wanted
        if not hasattr(method, "scheme") or method.scheme(1.0).average_stress:
            raise UnsupportedError(
                "method: expected Newmark, HHT, GeneralizedAlpha, WilsonTheta or, for a reduced model, "
                f"CentralDifference in a batch, got {method!r}"
            )
        wanted, secants = method.scheme(1.0).tolerance if tolerance is None else wanted, self._plant.secants
        return (lambda equation: ImplicitWalk(equation, method, time_step, wanted, secants)), wanted


def _check_maneuvers(
    maneuver: Maneuver, arrays: dict[str, NDArray[np.float64]], axes: dict[str, int | None], runs: int
) -> None:
    """Let the maneuver itself refuse numbers that are out of range."""
    own = {name.removeprefix("maneuver."): name for name in arrays if name.startswith("maneuver.")}
    for run in range(runs if any(axes[name] == 0 for name in own.values()) else min(1, len(own))):
        values: dict[str, Any] = {
            short: arrays[name][run] if axes[name] == 0 else arrays[name] for short, name in own.items()
        }
        replace(maneuver, **{short: float(v) if np.ndim(v) == 0 else v for short, v in values.items()})  # type: ignore[type-var]
