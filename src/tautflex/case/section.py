"""Base of every section of a case file, and the value types they share."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, Strict, ValidationError

from tautflex.case.messages import case_error, choices, problem

# Products of several of them stay within what arithmetic can hold.
_SMALLEST, _LARGEST = 1e-30, 1e30


def _bearable(value: float) -> float:
    if value and not _SMALLEST <= abs(value) <= _LARGEST:
        raise problem(f"a number between {_SMALLEST:g} and {_LARGEST:g} in size", value, "write it in SI units")
    return value


# Strict: an integer is a number, but true, "1" and 1.0-for-an-integer are mistakes worth hearing about.
Number = Annotated[float, Strict(), AfterValidator(_bearable)]
Positive = Annotated[Number, Field(gt=0.0)]
NonNegative = Annotated[Number, Field(ge=0.0)]
Count = Annotated[int, Strict(), Field(ge=1)]
Flag = Annotated[bool, Strict()]
Text = Annotated[str, Strict()]
Vector = tuple[Number, Number, Number]


class Words:
    """Validator of a word out of a list that may still grow, by what plugins register."""

    def __init__(self, words: Callable[[], Iterable[str]]) -> None:
        self.words = words

    def __call__(self, value: object) -> object:
        """Value if it is one of the words; ValueError otherwise."""
        known = list(self.words())
        if value not in known:
            raise problem(f"one of {choices(known)}", value, "choose one of them")
        return value


def key(meaning: str, example: Any = None, default: Any = ..., **given: Any) -> Any:
    """Key of a section: what it means, as messages and the reference say it, an example, and perhaps a default."""
    example = default if example is None and isinstance(default, str | float | int | tuple) else example
    return Field(default, description=meaning, examples=None if example is None else [example], **given)


class Section(BaseModel):
    """Frozen table of a case file: unknown keys, NaN and infinities are errors.

    Raises
    ------
    CaseError
        If a key is unknown, missing or has an unusable value.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)

    def __init__(self, /, **values: Any) -> None:
        try:
            super().__init__(**values)
        except ValidationError as error:
            raise case_error(error, type(self)) from None

    @classmethod
    def from_table(cls, values: Any) -> Any:
        """Make the section from a table of keys; anything else is left to pydantic to take or refuse."""
        return cls(**values) if isinstance(values, dict) else values
