"""Sections of a case file that describe a run: damping, coupling, solver, reduced model, output."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field, Strict, field_validator

from tautflex.case.messages import require_names
from tautflex.case.options import Built, Chosen, section_of
from tautflex.case.registry import BASES, DAMPINGS, METHODS
from tautflex.case.section import Count, NonNegative, Number, Positive, Section, Vector, key
from tautflex.errors import CaseError, InputError
from tautflex.motion import coupling

if TYPE_CHECKING:
    from tautflex.solvers.transient.adaptive import Adaptive


class Damping(Chosen):
    """Structural damping."""

    registry, standard_kind = DAMPINGS, "rayleigh"


class Coupling(section_of(coupling.Coupling), Built):  # type: ignore[misc] # its keys are the fields of that class
    """Terms of rigid-flexible coupling, each of which can be left out to see what it does."""

    target = coupling.Coupling


class Reduction(Chosen):
    """Reduced model in place of the full one: a basis of vectors, exact nonlinear forces; elastic laws only."""

    registry, standard_kind = BASES, "modal"

    def check_values(self) -> None:
        """Raise CaseError if the class refuses the values, or modes are chosen in two ways."""
        super().check_values()
        count, threshold = getattr(self, "count", None), getattr(self, "threshold", None)
        if count is not None and threshold != type(self).model_fields["threshold"].default:
            text = f"threshold: expected no value beside count = {count}, got {threshold:g}"
            raise CaseError(f"{text}; keep one of the two")


class Solver(Chosen):
    """Time integration."""

    registry, naming_key, standard_kind = METHODS, "method", "wilson-theta"
    time_step: Positive = key("time step, with adaptive_tolerance the spacing of results [s]", default=1e-3)
    end_time: Positive = key("end of the run [s]", default=10.0)
    tolerance: Positive | None = key("relative residual at which Newton stops", 1e-8, None)
    max_halvings: Annotated[int, Strict(), Field(ge=0)] | None = key(
        "number of times a failing step may be halved", 8, None
    )
    initial_imperfection: NonNegative = key(
        "largest displacement from the starting equilibrium, in the shape that grows fastest or resists least [m]",
        1e-6,
        0.0,
    )
    adaptive_tolerance: Number | None = key(
        "allowed error per step of an adaptive run, fixed steps if not given", 1e-4, None
    )
    min_step: Number | None = key("smallest adaptive step [s], time_step/4096 if not given", 1e-6, None)
    max_step: Number | None = key("largest adaptive step [s], 16 time_step if not given", 1e-2, None)

    time_error: Annotated[bool, Strict()] = Field(
        default=True,
        description="estimate the time error, at about 1 % of a run's cost; false: null in the JSON",
        examples=[True],
    )

    def check_values(self) -> None:
        """Raise CaseError if the class refuses the values, or they contradict each other."""
        super().check_values()
        given = [name for name in ("adaptive_tolerance", "min_step", "max_step") if getattr(self, name) is not None]
        if given and not issubclass(self.made_from or object, METHODS.bases[0]):
            text = f"{given[0]}: expected no value with {self.choice()}, got {getattr(self, given[0]):g}"
            raise CaseError(f"{text}; its step is limited by stability, remove it or use an implicit method")
        if given and self.adaptive_tolerance is None:
            text = f"{given[0]}: expected adaptive_tolerance with it, got {getattr(self, given[0]):g} alone"
            raise CaseError(f"{text}; add adaptive_tolerance = 1e-4 or remove {given[0]}")
        try:
            self.adaptive()
        except InputError as error:
            text = str(error).replace("adaptive.tolerance", "adaptive_tolerance").removeprefix("adaptive.")
            raise CaseError(self.in_words_of_the_case(text)) from None
        if self.end_time <= self.time_step:
            text = f"end_time: expected more than time_step = {self.time_step:g} s, got {self.end_time:g}"
            raise CaseError(f"{text}; run longer or with a smaller time_step")

    def adaptive(self) -> Adaptive | None:
        """Error control of the steps; None for fixed ones."""
        if self.adaptive_tolerance is None:
            return None
        from tautflex.solvers.transient.adaptive import Adaptive  # not needed to read a case of fixed steps

        control = Adaptive(self.adaptive_tolerance, self.min_step, self.max_step)
        control.limits(self.time_step)
        return control


class Output(Section):
    """What a run keeps: points read at every stored step, and whole fields at chosen instants."""

    probes: dict[str, tuple[Number, Number] | Vector] = key(
        "table of names and points: on the film, two numbers, or nodes of the frame, three [m]",
        {"A": [0.7036, 0.4267]},
        {},
    )
    probe_reading: Literal["interpolate", "nearest-node"] = key("how a probe reads the mesh", default="interpolate")
    every: Count = key("number of steps from one stored step to the next, >= 1", default=1)
    fields: Literal["none", "all"] | tuple[NonNegative, ...] = key(
        "word 'none', the word 'all', or a list of instants >= 0 [s]", (0.0, 0.5), "none"
    )
    frames: Annotated[int, Strict(), Field(ge=0)] = key(
        "number of evenly spaced instants whose displacements are kept for reports and films, in single precision, "
        "64 MB at most; 0 for none",
        default=300,
    )
    surface_tolerance: Positive = key(
        "rms of the film about its best plane [m] within which it counts as settled, > 0", default=2e-5
    )
    attitude_tolerance: Positive = key(
        "angle between a hub and what it follows [rad] within which it counts as settled, > 0", default=1e-3
    )

    @field_validator("probes")
    @classmethod
    def _probes_have_names(cls, value: dict[str, tuple[float, ...]]) -> dict[str, tuple[float, ...]]:
        require_names(value, "probe names", "A")
        return value
