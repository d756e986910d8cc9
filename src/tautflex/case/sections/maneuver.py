"""Section of a case file that says how the spacecraft moves: each maneuver's class is its own section."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, SerializeAsAny, Strict

from tautflex.case.messages import show
from tautflex.case.options import Chosen, within
from tautflex.case.registry import MANEUVERS
from tautflex.case.section import NonNegative, key
from tautflex.case.tables import COLUMNS, read_table
from tautflex.errors import CaseError

# What cards and summaries call the maneuvers of tautflex; any other one goes by its name and numbers.
_WORDS = {
    "none": "no maneuver",
    "stop": "stop from {rate:.4g} rad/s in {duration:g} s",
    "spin-up": "spin-up from {initial_rate:.4g} to {rate:.4g} rad/s in {duration:g} s",
    "slew": "{profile} slew by {angle:.4g} rad ({degrees:.3g}°) in {duration:g} s",
    "base-acceleration": "{profile} base acceleration of {acceleration:.4g} m/s^2",
}


class Motion(Chosen):
    """One maneuver, whether it stands alone or is a step of a sequence."""

    registry = MANEUVERS
    harmless_keys = ("axis", "origin")

    @classmethod
    def parts_for(cls, kind: str, target: type) -> tuple[type[Chosen], ...]:
        """A table may come from a file; a sequence has a table of keys for each step."""
        more: dict[str, type[Chosen]] = {"tabulated": _TableFile, "sequence": _Steps}
        return (more[kind], cls) if kind in more else (cls,)

    def describe(self) -> str:
        """What moves, in a few words for cards and summaries."""
        values = self.__dict__
        if self.kind not in _WORDS:
            numbers = (f"{name} = {value:.4g}" for name, value in values.items() if isinstance(value, float))
            return f"{self.kind} ({', '.join(numbers)})"
        span = f" for {self.duration:g} s" if self.kind == "base-acceleration" and self.duration is not None else ""
        if self.kind == "slew":
            values = values | {"degrees": math.degrees(values["angle"])}
        return _WORDS[self.kind].format(**values) + span


class _TableFile(Chosen):
    """Motion tables may stand in a file."""

    optional_keys = ("times",)
    file: Annotated[str, Strict()] | None = key("name of a CSV file with the table", "slew.csv", None)

    def check_values(self) -> None:
        given = [name for name in ("times", *COLUMNS) if getattr(self, name) is not None]
        if self.file is not None:
            if given:
                text = f"file: expected no file beside {given[0]}, got {show(self.file)}"
                raise CaseError(f"{text}; keep the file or the numbers")
            return
        if "times" not in given:
            text = f"file: missing, {self.choice()} expects a CSV file or times"
            raise CaseError(f"{text}; add for example file = 'slew.csv', or times and rates")
        super().check_values()

    def arguments(self) -> dict[str, Any]:
        return super().arguments() | ({} if self.file is None else read_table(self.file))

    def describe(self) -> str:
        rows = f"{len(self.times)} rows" if self.file is None else Path(self.file).name
        return f"tabulated motion ({rows})"


class Step(Motion):
    """One maneuver of a sequence, and how long its last motion is held."""

    hold: NonNegative | None = key("time from the end of the step to the next one [s], >= 0", 2.0, None)

    @classmethod
    def kinds(cls) -> list[str]:
        """Everything that moves by itself."""
        return [kind for kind in cls.registry if kind not in ("none", "sequence")]


class _Steps(Chosen):
    """A sequence is written as one [[maneuver.steps]] table for each maneuver."""

    omitted_fields = ("holds",)
    steps: tuple[Annotated[SerializeAsAny[Step], BeforeValidator(Step.from_table)], ...] = key(
        "list of maneuvers, one [[maneuver.steps]] table each", ({"kind": "slew", "angle": 0.35, "duration": 2.0},)
    )

    def check_values(self) -> None:
        if not self.steps:
            raise CaseError("steps: expected at least one [[maneuver.steps]] table, got none; add one")
        if self.steps[-1].hold is not None:
            text = f"steps: expected no hold in the last step, got {self.steps[-1].hold:g}"
            raise CaseError(f"{text}; remove it, the last motion is held for ever")
        if not any(getattr(step, "file", None) for step in self.steps):
            super().check_values()

    def arguments(self) -> dict[str, Any]:
        built = []
        for number, step in enumerate(self.steps):
            with within(f"steps.{number}"):
                built.append(step.build())
        return {"steps": tuple(built), "holds": tuple(step.hold or 0.0 for step in self.steps[:-1])}

    def describe(self) -> str:
        return ", then ".join(step.describe() for step in self.steps)


class Maneuver(Motion):
    """Prescribed motion of the spacecraft."""

    standard_kind = "none"
