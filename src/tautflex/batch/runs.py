"""Many runs at once: the public face of the room."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from tautflex import checks
from tautflex.batch.chunks import ChunkRunner, usual_chunk
from tautflex.batch.damping import BatchDamping
from tautflex.batch.equations.equation import STORED, EachRun
from tautflex.batch.equations.full import FullPlant
from tautflex.batch.equations.inputs import BatchInputs
from tautflex.batch.equations.rate_history import rate_history
from tautflex.batch.equations.reduced import ReducedPlant
from tautflex.batch.equations.stability import full_fall, instability_text
from tautflex.batch.library import PRECISIONS, jax
from tautflex.batch.output.dataset import to_dataset
from tautflex.batch.output.precision import checked_runs, single_precision_errors
from tautflex.batch.output.response import March, Response, response_function
from tautflex.batch.parameters import check_names, checked_numbers, each_row
from tautflex.batch.steps.explicit import ExplicitMarch
from tautflex.batch.steps.hub import HubMarch
from tautflex.batch.steps.implicit import ImplicitMarch
from tautflex.errors import InputError, NotConvergedError, UnsupportedError
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import Maneuver
from tautflex.reduction.polynomial.model import ReducedModel
from tautflex.solvers.static.prestress import PrestressedState, in_short
from tautflex.solvers.transient.accuracy.between import doubts_about_inputs
from tautflex.solvers.transient.free_hub.record import check_coupling
from tautflex.solvers.transient.methods.central_difference import CentralDifference
from tautflex.solvers.transient.methods.scheme import Method
from tautflex.solvers.transient.problem import TransientProblem
from tautflex.solvers.transient.status import Status
from tautflex.text import shown

# Keywords of `tautflex.simulate` that ask for what a batch does not do.
_NOT_IN_A_BATCH = frozenset({"adaptive", "every", "fields", "initial", "initial_imperfection", "max_halvings"})


class Batch:
    """Runs of one structure with other tensions, moduli, densities, damping, maneuvers, hubs and inputs, all at once.

    Parameters
    ----------
    plant
        Prestressed state (the full model), or a reduced model of it.
    precision
        ``"double"``, or of a reduced model ``"single"``: steps are made in single precision, and `simulate` repeats
        three of the runs in double precision to tell the error.

    Raises
    ------
    InputError
        If ``plant`` is neither, or ``precision`` is none of the two.
    UnsupportedError
        If its laws are not elastic, it can drift away, or it is too large; or a full model in single precision.
    MissingExtraError
        If JAX is not installed (when the name is first used).

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> question = {"time_step": 4e-3, "end_time": 1.0, "probes": {"A": (0.7, 0.4)}}
    >>> batch = tf.Batch(tf.reduce(state))
    >>> data = batch.simulate({"maneuver.duration": [0.5, 0.8, 1.0]}, tf.Stop(rate=0.628, duration=1.0), **question)
    >>> data.sizes["run"]
    3
    """

    def __init__(self, plant: PrestressedState | ReducedModel, precision: str = "double") -> None:
        expected, remedy = "a prestressed state or a reduced model", "solve_prestress(model) or reduce(state) gives one"
        checks.instance("plant", plant, (PrestressedState, ReducedModel), expected, remedy=remedy)
        checks.one_of("precision", precision, PRECISIONS)
        self._model, self._exact = plant, None
        if precision == "single":
            if isinstance(plant, PrestressedState):
                raise UnsupportedError(
                    "precision: expected 'double' for the full model, whose stiff film loses everything in single "
                    "precision, got 'single'; Batch(reduce(state), 'single') takes it"
                )
            self._exact = Batch(plant)
        self._plant = ReducedPlant(plant) if isinstance(plant, ReducedModel) else FullPlant(plant)
        self._run = ChunkRunner(self._plant.side_by_side)

    def __repr__(self) -> str:
        return f"Batch({shown(self._model) if isinstance(self._model, ReducedModel) else in_short(self._model)})"

    def response(
        self, maneuver: Maneuver | FreeHub | None = None, *, store: Sequence[str] = STORED, **question: Any
    ) -> Callable[[Mapping[str, Any]], Response]:
        """One run as a pure function of its parameters, for `jax.grad`, `jax.jit` and `jax.vmap`.

        Parameters
        ----------
        maneuver, question
            As for `simulate`.
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
        asked = _Asked(self._plant, self._problem(maneuver, question), store, self._exact is not None)
        function, damping = asked.function, asked.damping

        def respond(parameters: Mapping[str, Any]) -> Response:
            check_names(parameters, self._plant.kinds, asked.history, damping.defaults)
            alone = {**asked.defaults, **damping.defaults}
            numbers = {**alone, **parameters}
            differ = frozenset(name for name in parameters if np.ndim(numbers[name]) > np.ndim(alone.get(name, 0.0)))
            runs = len(numbers[min(differ)]) if differ else 1
            numbers, differ = damping.of_traced(numbers, differ)
            if differ:
                return self._run.many(function, differ, runs)(numbers)
            if not self._plant.side_by_side:
                return function(numbers, EachRun())
            return jax.tree.map(lambda part: part[..., 0], function(numbers, EachRun(1)))

        return respond

    def simulate(
        self,
        parameters: Mapping[str, ArrayLike],
        maneuver: Maneuver | FreeHub | None = None,
        *,
        store: Sequence[str] = STORED,
        chunk: int | None = None,
        throw: bool = True,
        **question: Any,
    ) -> xr.Dataset:
        """Runs with given parameters.

        Parameters
        ----------
        parameters
            Name -> one value per run, or one for all: ``"tension_x"``, ``"tension_y"``, ``"youngs_modulus.membrane"``
            (``.cable``, ``.beam``) and ``"density.membrane"`` are factors of the state; the numbers of the damping
            (``"damping.alpha"``, ``"damping.beta"``; ``"damping.ratio"``) and of the maneuver, such as
            ``"maneuver.rate"``, replace those of the arguments. Proportional damping follows the factors of the state,
            the vectors of modal damping are those of the state as given. Of a hub ``"hub.torque"`` [N m],
            ``"hub.angular_velocity"`` [rad/s] and ``"hub.inertia"`` (about its axis through the origin) [kg m^2]; of
            input number k a factor ``"inputs.k"``, and ``"inputs.k.values"``, its constant numbers or the rows of its
            table.
        maneuver
            Prescribed rigid motion, or for a reduced model a `FreeHub` of one axis; None is none.
        store
            What the result holds, of ``"displacement"``, ``"velocity"`` and ``"energy"``.
        chunk
            Runs computed side by side; None takes what suits a processor.
        throw
            Raise when a run fails; False returns all, failed ones labelled and NaN from where they failed.
        question
            As for `tautflex.simulate`: ``time_step``, ``end_time``, ``method``, ``damping``, ``coupling``, ``inputs``,
            ``probes``, ``probe_reading``, ``initial_velocity``, ``tolerance``.

        Returns
        -------
        xarray.Dataset
            Variables of `tautflex.simulate` with a dimension ``run``, and ``status`` of each run; ``attrs["warnings"]``
            says whether starts are unstable. On a hub ``angle``, ``attitude`` and ``angular_velocity`` too. In single
            precision ``attrs["single_precision_error_displacement"]`` (``_velocity``, ``_energy``, ``_angle``) is the
            largest error of the runs ``attrs["runs_in_double_precision"]``, over the largest value of each.

        Raises
        ------
        InputError
            If a parameter or an argument is out of range.
        UnsupportedError
            If the maneuver or the method has no batched form.
        NotConvergedError
            If a run fails and ``throw`` is set; ``.result`` holds all runs.
        """
        problem = self._problem(maneuver, question)
        asked = _Asked(self._plant, problem, store, self._exact is not None)
        damping = asked.damping
        arrays, axes, runs = checked_numbers(parameters, self._plant.kinds, asked.history, damping.defaults)
        for row in each_row("maneuver.", arrays, axes, runs):
            # The maneuver itself refuses numbers that are out of range.
            replace(problem.maneuver, **row)  # type: ignore[type-var]
        if "hub.inertia" in arrays and arrays["hub.inertia"].min() <= 0.0:
            raise InputError(
                f"parameters: expected 'hub.inertia' > 0 kg m^2, got {float(arrays['hub.inertia'].min())!r}"
            )
        asked.inputs.check(each_row("inputs.", arrays, axes, runs))
        of_damping, rows = damping.of_rows(arrays, axes, runs)
        others = {name: array for name, array in arrays.items() if name not in damping.defaults}
        fixed = {name: np.asarray(value, dtype=float) for name, value in asked.defaults.items()}
        numbers = {**fixed, **others, **of_damping}
        differ = frozenset(name for name in others if axes[name] == 0) | rows
        usual = usual_chunk(runs, self._plant.side_by_side)
        at_once = min(runs, usual if chunk is None else checks.whole("chunk", chunk, 1))
        record = self._run(asked.function, asked.key, numbers, differ, runs, at_once)
        data = to_dataset(record, arrays, axes, runs, problem)
        falls = _full_falls(self._plant, problem, arrays, axes, runs) if record.fall is None else record.fall
        data.attrs["warnings"] = [*problem.doubts, *asked.doubts, *instability_text(np.asarray(falls))]
        if self._exact is not None:
            chosen = checked_runs(runs)
            some = {name: array[chosen] if axes[name] == 0 else array for name, array in arrays.items()}
            double = self._exact.simulate(some, maneuver, store=store, throw=False, **question)
            again = data.isel(run=chosen[: double.sizes["run"]])
            errors, words = single_precision_errors(again, double.assign_coords(run=again["run"]))
            data.attrs["runs_in_double_precision"] = chosen
            data.attrs |= {f"single_precision_error_{name}": error for name, error in errors.items()}
            data.attrs["warnings"] += words
        failed = int(np.sum(data["status"].values != Status.COMPLETED.value))
        if failed and throw:
            raise NotConvergedError(f"{failed} of {runs} runs: {Status.NOT_CONVERGED.message}", result=data)
        return data

    def _problem(self, maneuver: Maneuver | FreeHub | None, question: Mapping[str, Any]) -> TransientProblem:
        """The question that all runs answer; UnsupportedError for what a batch does not do."""
        if isinstance(maneuver, FreeHub) and isinstance(self._plant, FullPlant):
            raise UnsupportedError(
                "maneuver: expected a prescribed motion for the full model in a batch, got FreeHub(...); "
                "Batch(reduce(state)) takes it, or simulate one by one"
            )
        for name in _NOT_IN_A_BATCH & question.keys():
            raise UnsupportedError(f"{name}: expected no such keyword in a batch, got it; simulate runs one by one")
        return TransientProblem.asked(self._model, maneuver, question)


def _full_falls(
    plant: Any, problem: TransientProblem, arrays: dict[str, Any], axes: dict[str, int | None], runs: int
) -> NDArray[np.float64]:
    """How the runs of a full model leave their starts, see `Response`, shape (run,)."""
    found, maneuver = [], cast(Maneuver, problem.maneuver)
    for row in each_row("", arrays, axes, runs) if arrays else [{}]:
        own = {name.removeprefix("maneuver."): value for name, value in row.items() if name.startswith("maneuver.")}
        found.append(full_fall(plant, row, replace(maneuver, **own).start(), problem.coupling))  # type: ignore[type-var]
    return np.broadcast_to(found, (runs,))


class _Asked:
    """A problem as functions of its numbers; raises as `Batch.simulate` for what has no batched form."""

    def __init__(
        self, plant: FullPlant | ReducedPlant, problem: TransientProblem, store: Sequence[str], single: bool
    ) -> None:
        march_of = _march_of(plant, problem)
        store = checks.several("store", store, str, repr(STORED[0]))
        for name in store:
            checks.one_of("store", name, STORED)
        self.inputs = inputs = BatchInputs(InputSet(plant.state.system, problem.inputs))
        self.history = history = inputs.driving(rate_history(problem.maneuver))
        velocity = problem.velocity
        if isinstance(plant, ReducedPlant):
            velocity = plant.rom.coordinates(velocity)
            plant.rom.arrays(problem.damping)  # refuses what no reduced model can do
        if history.hub is not None:
            check_coupling(problem.coupling)
        self.function = response_function(plant, problem, history, inputs, velocity, store, march_of, single)
        self.doubts = _doubts(plant, problem, inputs) if inputs else []
        self.damping = BatchDamping(problem.damping, plant.state.linear)
        self.defaults = history.numbers
        # What tells the compiled function from others.
        self.key: Hashable = (
            history.key,
            history.axis,
            history.origin,
            problem.coupling,
            problem.method,
            problem.placed.map.toarray().tobytes(),
            velocity.tobytes(),
            (problem.time_step, problem.count, problem.tolerance),
            store,
            self.damping.matrix.rank,
            tuple(self.damping.matrix.kinds),
        )


def _doubts(plant: FullPlant | ReducedPlant, problem: TransientProblem, inputs: BatchInputs) -> list[str]:
    """What to know about inputs, in words, as in a single run with the signals that were given."""
    found = doubts_about_inputs(inputs.given, problem)
    if not isinstance(problem.maneuver, FreeHub):
        found += inputs.given.idle()
    if isinstance(plant, ReducedPlant):
        beta = float(problem.damping.matrix(plant.state.linear).stiffness)
        found += plant.of_inputs(inputs).doubts(problem.count * problem.time_step, beta)
    return found


def _march_of(plant: FullPlant | ReducedPlant, problem: TransientProblem) -> Callable[[Any], March]:
    """What makes the steps of an equation."""
    method, step = problem.method, problem.time_step
    if isinstance(method, CentralDifference):
        if not plant.side_by_side:
            raise UnsupportedError(
                "method: expected an implicit method for the full model in a batch, got CentralDifference(), whose "
                "stable step is thousands of times smaller; Batch(reduce(state)) takes it"
            )
        hub = isinstance(problem.maneuver, FreeHub)
        return lambda equation: (HubMarch if hub else ExplicitMarch)(equation, step)
    if isinstance(problem.maneuver, FreeHub):
        raise UnsupportedError(
            f"method: expected CentralDifference() on a free hub in a batch, got {method!r}; simulate one by one"
        )
    if not isinstance(method, Method) or method.average_stress:
        raise UnsupportedError(
            "method: expected Newmark, HHT, GeneralizedAlpha, WilsonTheta, Bathe or, for a reduced model, "
            f"CentralDifference in a batch, got {method!r}"
        )
    tolerance = problem.tolerance or method.tolerance
    return lambda equation: ImplicitMarch(equation, method, step, tolerance, plant.pairs)
