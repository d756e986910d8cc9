"""Sections of a case file that describe a run: damping, coupling, solver, output."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, Strict, field_validator, model_validator

from tautflex.case.messages import problem
from tautflex.case.section import Count, Flag, NonNegative, Number, Positive, Section

OPTIONS_OF_METHOD = {
    "wilson-theta": ("theta",),
    "generalized-alpha": ("rho_inf",),
    "newmark": ("gamma", "beta"),
    "hht": ("alpha",),
    "energy-conserving": (),
    "central-difference": (),
}
ADAPTIVE = ("adaptive_tolerance", "min_step", "max_step")


class Damping(Section):
    """Rayleigh damping ``C = alpha M + beta K`` [paper, section 3]."""

    alpha: NonNegative = Field(default=0.0, description="mass coefficient [1/s], >= 0", examples=[0.001])
    beta: NonNegative = Field(default=0.0, description="stiffness coefficient [s], >= 0", examples=[0.001])


class Coupling(Section):
    """Terms of rigid-flexible coupling, each of which can be left out to see what it does."""

    gyroscopic: Flag = Field(
        default=True, description="choice true or false: keep the gyroscopic matrix", examples=[True]
    )
    euler: Flag = Field(
        default=True,
        description="choice true or false: keep the angular-acceleration matrix",
        examples=[True],
    )
    centrifugal: Flag = Field(
        default=True, description="choice true or false: keep the centrifugal matrix", examples=[True]
    )
    inertial_load: Flag = Field(
        default=True, description="choice true or false: keep the load of the rigid motion", examples=[True]
    )


class Solver(Section):
    """Time integration; an option that ``method`` does not use is an error."""

    method: Literal[
        "wilson-theta", "generalized-alpha", "newmark", "hht", "energy-conserving", "central-difference"
    ] = Field(default="wilson-theta", description="time integrator", examples=["wilson-theta"])
    time_step: Positive = Field(
        default=1e-3, description="time step, with adaptive_tolerance the spacing of results [s]", examples=[1e-3]
    )
    end_time: Positive = Field(default=10.0, description="end of the run [s]", examples=[10.0])
    theta: Annotated[float, Strict(), Field(ge=1.0, le=2.0)] | None = Field(
        default=None, description="value of Wilson's theta, 1.4 if not given", examples=[1.4]
    )
    rho_inf: Annotated[float, Strict(), Field(ge=0.0, le=1.0)] | None = Field(
        default=None, description="spectral radius at infinite frequency, 0 to 1", examples=[0.8]
    )
    gamma: Annotated[float, Strict(), Field(ge=0.5, le=1.0)] | None = Field(
        default=None, description="value of Newmark's gamma, 0.5 to 1", examples=[0.5]
    )
    beta: Annotated[float, Strict(), Field(gt=0.0, le=1.0)] | None = Field(
        default=None, description="value of Newmark's beta, 0 to 1", examples=[0.25]
    )
    alpha: Annotated[float, Strict(), Field(ge=0.0, le=1.0 / 3.0)] | None = Field(
        default=None, description="value of the HHT method's alpha, 0 to 1/3", examples=[0.05]
    )
    tolerance: Positive | None = Field(
        default=None, description="relative residual at which Newton stops", examples=[1e-8]
    )
    max_halvings: Annotated[int, Strict(), Field(ge=0)] | None = Field(
        default=None, description="number of times a failing step may be halved", examples=[8]
    )
    adaptive_tolerance: Annotated[float, Strict(), Field(gt=0.0, le=0.1)] | None = Field(
        default=None, description="allowed error per step of an adaptive run, fixed steps if not given", examples=[1e-4]
    )
    min_step: Positive | None = Field(
        default=None, description="smallest adaptive step [s], time_step/4096 if not given", examples=[1e-6]
    )
    max_step: Positive | None = Field(
        default=None, description="largest adaptive step [s], 16 time_step if not given", examples=[1e-2]
    )

    @property
    def options(self) -> dict[str, float]:
        """Options of the method that the case states; the method itself knows the defaults of the others."""
        values = {name: getattr(self, name) for name in OPTIONS_OF_METHOD[self.method]}
        return {name: value for name, value in values.items() if value is not None}

    @model_validator(mode="after")
    def _options_of_method(self) -> Self:
        used = OPTIONS_OF_METHOD[self.method]
        for name in (name for names in OPTIONS_OF_METHOD.values() for name in names):
            if name not in used and getattr(self, name) is not None:
                text = f"{name}: expected no value with method = {self.method!r}, got {getattr(self, name):g}"
                raise ValueError(f"{text}; remove it, that method uses {' and '.join(used) or 'no options'}")
        return self

    @model_validator(mode="after")
    def _adaptive_keys_agree(self) -> Self:
        given = [name for name in ADAPTIVE if getattr(self, name) is not None]
        if given and self.method == "central-difference":
            text = f"{given[0]}: expected no value with method = 'central-difference', got {getattr(self, given[0]):g}"
            raise ValueError(f"{text}; its step is limited by stability, remove it or use an implicit method")
        if given and self.adaptive_tolerance is None:
            text = f"{given[0]}: expected adaptive_tolerance with it, got {getattr(self, given[0]):g} alone"
            raise ValueError(f"{text}; add adaptive_tolerance = 1e-4 or remove {given[0]}")
        low = self.time_step / 4096 if self.min_step is None else self.min_step
        if self.max_step is not None and self.max_step < low:
            text = f"max_step: expected at least min_step = {low:g} s, got {self.max_step:g}"
            raise ValueError(f"{text}; enlarge it or give a smaller min_step")
        return self

    @model_validator(mode="after")
    def _at_least_one_step(self) -> Self:
        if self.end_time <= self.time_step:
            text = f"end_time: expected more than time_step = {self.time_step:g} s, got {self.end_time:g}"
            raise ValueError(f"{text}; run longer or with a smaller time_step")
        return self


class Output(Section):
    """What a run keeps: points read at every stored step, and whole fields at chosen instants."""

    probes: dict[str, tuple[Number, Number]] = Field(
        default={},
        description="table of names and points on the film [m]",
        examples=[{"A": [0.7036, 0.4267]}],
    )
    probe_reading: Literal["interpolate", "nearest-node"] = Field(
        default="interpolate", description="how a probe reads the mesh", examples=["interpolate"]
    )
    every: Count = Field(default=1, description="number of steps from one stored step to the next, >= 1", examples=[1])
    fields: Literal["none", "all"] | tuple[NonNegative, ...] = Field(
        default="none",
        description="word 'none', the word 'all', or a list of instants >= 0 [s]",
        examples=[(0.0, 0.5)],
    )

    @field_validator("probes")
    @classmethod
    def _probes_have_names(cls, value: dict[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
        for name in value:
            if not name.strip() or not name.isprintable():
                raise problem("probe names of printable characters", name, "name it for example A")
        return value
