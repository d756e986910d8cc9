"""Base of every section of a case file, and the value types they share."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Annotated, Any, get_args

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, Strict, ValidationError
from pydantic.fields import FieldInfo

from tautflex import checks
from tautflex.case.messages import case_error, choices, problem, show
from tautflex.errors import CaseError

DEGREES = "_deg"
"""What the name of a key ends with that is given in degrees."""
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
            raise problem(f"one of {choices(known)}", value, checks.pick(value, known))
        return value


def key(meaning: str, example: Any = None, default: Any = ..., **given: Any) -> Any:
    """Key of a section: what it means, as messages and the reference say it, an example, and perhaps a default."""
    example = default if example is None and isinstance(default, str | float | int | tuple) else example
    return Field(default, description=meaning, examples=None if example is None else [example], **given)


class Section(BaseModel):
    """Frozen table of a case file: unknown keys, NaN and infinities are errors.

    Every key in rad, rad/s or rad/s^2 can be given in degrees instead, its name followed by ``_deg``.

    Raises
    ------
    CaseError
        If a key is unknown, missing or has an unusable value.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)

    def __init__(self, /, **values: Any) -> None:
        problems = self._problems(values)
        if problems:
            raise CaseError(*problems, *self._further(values, problems))

    def _problems(self, values: dict[str, Any]) -> tuple[str, ...]:
        """Take the keys; what is wrong with them, as far as it is found at once."""
        try:
            super().__init__(**_in_radians(values, type(self)))
        except ValidationError as error:
            return case_error(error, type(self)).problems
        except CaseError as error:
            return error.problems
        return ()

    def _further(self, values: dict[str, Any], problems: Sequence[str]) -> Iterator[str]:
        """What keys that are wrong keep from being asked: it is asked twice, with other values in their places.

        Told is what is the same both times, so that it is about nothing but the other keys.
        """
        known, replaced = dict(values), (dict[str, Any](), dict[str, Any]())
        while problems:
            for text in problems:
                name, meant = _key_of(text), meant_by(text)
                known.pop(name + DEGREES, None)
                given, field = known.pop(name, None), type(self).model_fields.get(name)
                example = None if field is None or not field.examples else field.examples[0]
                if field is None:  # no key; what it may be meant for is asked as that
                    known |= {} if meant is None else {meant: values.get(meant, given)}
                elif example is None or (field.is_required() and not isinstance(example, float | int | str | tuple)):
                    return
                else:
                    replaced[0][name] = example
                    if field.is_required():
                        replaced[1][name] = _halved(example)
            first, second = (self._problems(known | others) for others in replaced)
            problems = [text for text in first if text in second and _key_of(text) in known]
            yield from (text for text in problems if _key_of(text) in values)

    @classmethod
    def from_table(cls, values: Any) -> Any:
        """Make the section from a table of keys; anything else is left to pydantic to take or refuse."""
        return cls(**values) if isinstance(values, dict) else values


def _halved(example: Any) -> Any:
    """Another value of the kind of an example."""
    if isinstance(example, tuple):
        return tuple(_halved(part) for part in example)
    return example / 2 if isinstance(example, float) else example


def _key_of(problem: str) -> str:
    """First key that a problem of a section is about."""
    return re.split("[.:]", problem, maxsplit=1)[0]


def meant_by(problem: str) -> str | None:
    """Key that a misspelt one is taken for."""
    found = re.search(r"; did you mean '(\w+)'\?$", problem)
    return None if found is None else found[1]


def section_of_field(field: FieldInfo) -> type[Section] | None:
    """The section that a field of the case holds, if it holds one."""
    waiting = [field.annotation]
    while waiting:
        one = waiting.pop()
        if isinstance(one, type) and issubclass(one, Section):
            return one
        waiting += get_args(one)
    return None


def _in_radians(values: dict[str, Any], section: type[Section]) -> dict[str, Any]:
    """Keys of a section with those in degrees, ``angle_deg``, as what they stand for."""
    found = dict(values)
    for name in values:
        meant = name.removesuffix(DEGREES)
        field = section.model_fields.get(meant)
        if name in section.model_fields or field is None or "[rad" not in (field.description or ""):
            continue
        if meant in values:
            raise CaseError(f"{name}: expected no value beside {meant}, got {show(values[name])}; keep one of the two")
        found[meant] = _radians(found.pop(name))
    return found


def _radians(value: Any) -> Any:
    """Numbers in degrees, in lists and tables of values too, in radians; the rest is left for its key to refuse."""
    if isinstance(value, list | tuple):
        return [_radians(part) for part in value]
    if isinstance(value, dict) and "values" in value:
        return value | {"values": _radians(value["values"])}
    return math.radians(value) if isinstance(value, int | float) and not isinstance(value, bool) else value
