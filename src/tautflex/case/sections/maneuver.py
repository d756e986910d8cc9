"""Section of a case file that says how the spacecraft moves, and which keys each kind of maneuver uses."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, Strict, field_validator, model_validator

from tautflex.case.messages import problem, show
from tautflex.case.section import NonNegative, Number, Positive, Section, Vector

Quaternion = tuple[Number, Number, Number, Number]
Ratio = Annotated[float, Strict(), Field(ge=0.0, lt=1.0)]

# Needed keys and further ones of each kind; the first kind that uses a key is the remedy where it does not belong.
KEYS_OF_KIND: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "none": ((), ()),
    "stop": (("rate", "duration"), ("axis", "origin")),
    "spin-up": (("rate", "duration"), ("profile", "initial_rate", "axis", "origin")),
    "slew": (
        ("angle", "duration"),
        ("profile", "frequency", "damping_ratio", "shaper", "base", "axis", "origin"),
    ),
    "tabulated": ((), ("file", "times", "rates", "quaternions", "accelerations", "ends", "axis", "origin")),
    "base-acceleration": (("acceleration",), ("duration", "profile", "axis")),
    "sequence": (("steps",), ()),
}
PROFILES_OF_KIND = {
    "spin-up": ("versine", "linear", "minimum-jerk"),
    "slew": ("versine", "bang-bang", "minimum-jerk", "input-shaped"),
    "base-acceleration": ("constant", "half-sine", "cut-off"),
}
SHAPING_KEYS = ("frequency", "damping_ratio", "shaper", "base")
TABLE_KEYS = ("times", "rates", "quaternions", "accelerations")
MEANING_OF_RATE = {"stop": "angular velocity before t = 0 [rad/s]", "spin-up": "angular velocity to reach [rad/s]"}


class Motion(Section):
    """Keys of one maneuver, whether it stands alone or is a step of a sequence."""

    kind: str
    rate: Number | None = Field(default=None, description="angular velocity [rad/s]", examples=[0.628])
    duration: Positive | None = Field(default=None, description="length of the maneuver [s], > 0", examples=[1.0])
    axis: Vector = Field(default=(1.0, 0.0, 0.0), description="direction of the axis", examples=[(1.0, 0.0, 0.0)])
    origin: Vector = Field(default=(0.0, 0.0, 0.0), description="point on the axis [m]", examples=[(0.0, 0.0, 0.0)])
    angle: Number | None = Field(default=None, description="angle of the turn [rad]", examples=[0.35])
    profile: (
        Literal["versine", "linear", "bang-bang", "minimum-jerk", "input-shaped", "constant", "half-sine", "cut-off"]
        | None
    ) = Field(default=None, description="course of the motion over time", examples=["versine"])
    initial_rate: Number | None = Field(
        default=None, description="angular velocity before t = 0 [rad/s]", examples=[0.0]
    )
    frequency: Positive | None = Field(
        default=None, description="natural frequency of the mode to leave at rest [Hz], > 0", examples=[1.0]
    )
    damping_ratio: Ratio | None = Field(default=None, description="damping ratio of that mode", examples=[0.01])
    shaper: Literal["ZV", "ZVD"] | None = Field(default=None, description="input shaper", examples=["ZVD"])
    base: Literal["bang-bang", "versine", "minimum-jerk"] | None = Field(
        default=None, description="profile that the shaper copies", examples=["bang-bang"]
    )
    acceleration: Number | None = Field(
        default=None, description="acceleration of the frame's origin [m/s^2]", examples=[0.05]
    )
    file: str | None = Field(default=None, description="name of a CSV file with the table", examples=["slew.csv"])
    times: tuple[Number, ...] | None = Field(
        default=None, description="instants of the table [s], rising from 0", examples=[(0.0, 1.0)]
    )
    rates: tuple[Number, ...] | tuple[Vector, ...] | None = Field(
        default=None, description="table of angular velocities, one number or [x, y, z] [rad/s]", examples=[(0.6, 0.0)]
    )
    quaternions: tuple[Quaternion, ...] | None = Field(
        default=None,
        description="table of attitudes, scalar first",
        examples=[((1.0, 0.0, 0.0, 0.0), (0.98, 0.199, 0.0, 0.0))],
    )
    accelerations: tuple[Number, ...] | tuple[Vector, ...] | None = Field(
        default=None,
        description="table of accelerations of the origin, one number or [x, y, z] [m/s^2]",
        examples=[(0.1, 0.0)],
    )
    ends: Literal["free", "rest"] | None = Field(
        default=None, description="choice whether a table of quaternions begins and ends at rest", examples=["rest"]
    )

    @field_validator("axis")
    @classmethod
    def _axis_has_length(cls, value: Vector) -> Vector:
        if not any(value):
            raise problem("a direction of non-zero length", value, "give for example [1, 0, 0]")
        return value

    @model_validator(mode="after")
    def _keys_of_kind(self) -> Self:
        needed, further = KEYS_OF_KIND[self.kind]
        fields = type(self).model_fields
        for name in needed:
            if getattr(self, name) is None:
                meaning = MEANING_OF_RATE[self.kind] if name == "rate" else fields[name].description
                raise ValueError(f"{name}: missing, kind = '{self.kind}' expects the {meaning}; add it")
        for name, field in fields.items():
            if name in ("kind", "hold", *needed, *further) or getattr(self, name) == field.default:
                continue
            other = next(kind for kind, keys in KEYS_OF_KIND.items() if name in (*keys[0], *keys[1]))
            text = f"{name}: expected no value with kind = '{self.kind}', got {show(getattr(self, name))}"
            raise ValueError(f"{text}; remove it or set kind = '{other}'")
        return self

    @model_validator(mode="after")
    def _profile_of_kind(self) -> Self:
        offered = PROFILES_OF_KIND.get(self.kind, ())
        if self.profile is not None and self.profile not in offered:
            names = ", ".join(f"'{name}'" for name in offered)
            text = f"profile: expected one of {names} with kind = '{self.kind}', got '{self.profile}'"
            raise ValueError(f"{text}; choose one of them")
        if self.profile == "input-shaped" and self.frequency is None:
            text = "frequency: missing, profile = 'input-shaped' expects the mode's natural frequency [Hz]"
            raise ValueError(f"{text}; add it, `tautflex modes` lists them")
        for name in SHAPING_KEYS:
            if self.profile != "input-shaped" and getattr(self, name) is not None:
                text = f"{name}: expected no value with profile = {show(self.profile or 'versine')}"
                raise ValueError(f"{text}, got {show(getattr(self, name))}; set profile = 'input-shaped'")
        if self.profile == "half-sine" and self.duration is None:
            raise ValueError("duration: missing, profile = 'half-sine' expects the length of the pulse [s]; add it")
        if self.profile == "cut-off" and self.duration is not None:
            text = f"duration: expected no value with profile = 'cut-off', got {self.duration:g}"
            raise ValueError(f"{text}; remove it, the acceleration ends at t = 0")
        return self

    @model_validator(mode="after")
    def _one_table(self) -> Self:
        if self.kind != "tabulated":
            return self
        given = [name for name in TABLE_KEYS if getattr(self, name) is not None]
        if self.file is not None and given:
            text = f"file: expected no file beside {given[0]}, got {show(self.file)}"
            raise ValueError(f"{text}; keep the file or the numbers")
        if self.file is None and "times" not in given:
            text = "file: missing, kind = 'tabulated' expects a CSV file or times"
            raise ValueError(f"{text}; add for example file = 'slew.csv', or times and rates")
        if self.file is None and given == ["times"]:
            raise ValueError(
                "rates: missing, times expects rates, quaternions or accelerations beside it; add one of them"
            )
        for name in given[1:]:
            if len(getattr(self, name)) != len(self.times or ()):
                text = f"{name}: expected {len(self.times or ())} rows, as many as times has"
                raise ValueError(f"{text}, got {len(getattr(self, name))}; give one per instant")
        return self


class Step(Motion):
    """One maneuver of a sequence, and how long its last motion is held."""

    kind: Literal["stop", "spin-up", "slew", "tabulated", "base-acceleration"] = Field(
        description="maneuver of this step", examples=["slew"]
    )
    hold: NonNegative | None = Field(
        default=None, description="time from the end of the step to the next one [s], >= 0", examples=[2.0]
    )


class Maneuver(Motion):
    """Prescribed motion of the spacecraft.

    ``"stop"``: steady rotation at ``rate`` until t = 0, uniform deceleration to rest over ``duration``.
    ``"spin-up"``: from ``initial_rate`` to ``rate``. ``"slew"``: turn by ``angle`` from rest to rest.
    ``"tabulated"``: through a table. ``"base-acceleration"``: translation along ``axis``.
    ``"sequence"``: the ``steps`` one after the other. ``"none"``: no motion.
    """

    kind: Literal["stop", "none", "spin-up", "slew", "tabulated", "base-acceleration", "sequence"] = Field(
        default="none", description="maneuver", examples=["stop"]
    )
    steps: tuple[Step, ...] | None = Field(
        default=None,
        description="list of maneuvers, one [[maneuver.steps]] table each",
        examples=[({"kind": "slew", "angle": 0.35, "duration": 2.0},)],
    )

    @model_validator(mode="after")
    def _steps_can_follow(self) -> Self:
        if self.steps is None:
            return self
        if not self.steps:
            raise ValueError("steps: expected at least one [[maneuver.steps]] table, got none; add one")
        if self.steps[-1].hold is not None:
            text = f"steps: expected no hold in the last step, got {self.steps[-1].hold:g}"
            raise ValueError(f"{text}; remove it, the last motion is held for ever")
        return self
