"""Sections made from classes: the fields of a frozen dataclass are the keys, its docstring is the help.

A section names a class by one key (``kind``, or ``method`` of the solver). What the keys mean, which are needed and
which ranges they have is the class's own business: the section is checked by making the object.
"""

from __future__ import annotations

import dataclasses
import types
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache, partial
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self, Union, get_args, get_origin, get_type_hints

from numpy.typing import ArrayLike
from pydantic import BeforeValidator, Field, Strict, create_model, model_validator

from tautflex import checks
from tautflex.case.help import docstrings
from tautflex.case.messages import choices, meaning, show
from tautflex.case.registry import Registry
from tautflex.case.section import DEGREES, Flag, Number, Section
from tautflex.case.tables import TimeTableKeys
from tautflex.errors import CaseError, InputError

# Type of a case file's value for each of Python's, and the example of messages and documents where there is no default.
_TYPES: dict[Any, tuple[Any, Any]] = {
    float: (Number, 1.0),
    int: (Annotated[int, Strict()], 1),
    bool: (Flag, True),
    str: (Annotated[str, Strict()], "text"),
}
_TABLE: Any = tuple[Number, ...] | tuple[tuple[Number, ...], ...]
_IN_TIME: Any = Annotated[Number | tuple[Number, ...] | TimeTableKeys, BeforeValidator(TimeTableKeys.from_table)]


def value_type(hint: Any) -> tuple[Any, Any]:
    """Type of a case file's value for the annotation of a field, and an example; TypeError if no case can hold it."""
    parts = get_args(hint)
    if get_origin(hint) in (Union, types.UnionType):
        if any(get_origin(part) is Callable for part in parts):
            return _IN_TIME, 1.0
        array = set(get_args(ArrayLike))  # its parts come one by one, text among them
        whole = array <= set(parts)
        rest = set(parts) - array if whole else set(parts)
        inner = [value_type(part) for part in parts if part in rest and part is not type(None)]
        kinds, examples = [kind for kind, _ in inner], [example for _, example in inner]
        if whole:
            kinds, examples = [*kinds, _TABLE], [*examples, (0.0, 1.0)]
        if type(None) in parts:
            kinds.append(None)
        return Union[tuple(kinds)], examples[0]  # noqa: UP007 - how many there are is only known here
    if get_origin(hint) is Mapping:
        kind, example = value_type(parts[1])
        return dict[str, kind], {"name": example}  # type: ignore[valid-type]
    if get_origin(hint) in (tuple, list, Sequence):
        inner = [value_type(part) for part in parts if part is not Ellipsis]
        kinds = [kind for kind, _ in inner]
        repeated = get_origin(hint) is not tuple or Ellipsis in parts
        return tuple.__class_getitem__((kinds[0], ...) if repeated else tuple(kinds)), tuple(
            example for _, example in inner
        )
    if get_origin(hint) is dict and parts[0] is str:
        kind, example = value_type(parts[1])
        return dict.__class_getitem__((str, kind)), {"name": example}
    if get_origin(hint) is Literal:
        return hint, parts[0]
    if hint not in _TYPES:
        raise TypeError(hint)
    return _TYPES[hint]


class Chosen(Section):
    """Section whose further keys are the fields of one of several registered classes.

    Sub-classes say among which; calling one of them with the keys of a section gives the section of the class that
    the keys name, ``Maneuver(kind="stop", rate=0.6, duration=1.0)``.

    Raises
    ------
    CaseError
        If a key does not belong to that class, is missing, or has a value that the class refuses.
    """

    registry: ClassVar[Registry]
    naming_key: ClassVar[str] = "kind"
    standard_kind: ClassVar[str | None] = None
    """Class that is meant where the case names none; None: it must."""
    harmless_keys: ClassVar[tuple[str, ...]] = ()
    """Keys that may stand with any class as long as they have the value that others take for granted."""
    omitted_fields: ClassVar[tuple[str, ...]] = ()
    """Fields of the class that are no keys, because others stand for them."""
    optional_keys: ClassVar[tuple[str, ...]] = ()
    """Fields that the class needs, which the case may give by other keys."""
    made_from: ClassVar[type | None] = None
    origin_section: ClassVar[type[Chosen]]

    def __new__(cls, /, **values: Any) -> Self:
        """Section of the class that the keys name."""
        if cls.made_from is not None:
            return super().__new__(cls)
        return super().__new__(cls.of_kind(values.get(cls.naming_key, cls.standard_kind)))

    def __reduce__(self) -> tuple[Any, ...]:
        """Classes made on the fly have no place that other processes could import them from."""
        return partial(self.chooser(), **self.model_dump(exclude_none=True)), ()

    if TYPE_CHECKING:  # the keys of the class, which type checkers cannot know

        def __getattr__(self, name: str) -> Any: ...

    @classmethod
    def kinds(cls) -> list[str]:
        """Names of the classes."""
        return list(cls.registry)

    @classmethod
    def of_kind(cls, kind: object) -> type[Self]:
        """Section of a class by its name."""
        if kind is None:
            example = f"{cls.naming_key} = {cls.kinds()[0]!r}"
            raise CaseError(
                f"{cls.naming_key}: missing, expected one of {choices(cls.kinds())}, for example {example}; add it"
            )
        if kind not in cls.kinds():
            text = f"{cls.naming_key}: expected one of {choices(cls.kinds())}, got {show(kind)}"
            raise CaseError(f"{text}; {checks.pick(kind, cls.kinds())}")
        return _section(cls.chooser(), str(kind), cls.registry[str(kind)])

    @classmethod
    def chooser(cls) -> type[Self]:
        """Section that chooses among the classes."""
        return cls if cls.made_from is None else cls.origin_section  # type: ignore[return-value]

    @classmethod
    def parts_for(cls, kind: str, target: type) -> tuple[type[Chosen], ...]:
        """Sections that together hold the keys of a class which are not its fields."""
        return (cls,)

    @classmethod
    def needed_keys(cls, target: type) -> tuple[str, ...]:
        """Fields that a case must give, though the class can do without."""
        return ()

    @classmethod
    def unused_fields(cls, target: type) -> tuple[str, ...]:
        """Fields that a case cannot give, because another one sets them."""
        return ()

    @classmethod
    def homes(cls) -> dict[str, str]:
        """Keys of all classes, and the first class that has each, for a guess at what a misplaced one means."""
        return {name: kind for kind in reversed(cls.kinds()) for name in cls.of_kind(kind).model_fields}

    @classmethod
    def foreign_keys(cls, values: Mapping[str, Any]) -> list[str]:
        """Keys of a table that belong to other classes than the one that it names."""
        if values.get(cls.naming_key) not in cls.kinds():
            return []
        own = cls.of_kind(values[cls.naming_key]).model_fields
        return [
            name
            for name in values
            if name.removesuffix(DEGREES) in cls.homes() and name.removesuffix(DEGREES) not in own
        ]

    @model_validator(mode="before")
    @classmethod
    def _without_harmless_keys(cls, values: Any) -> Any:
        if cls.made_from is None or not isinstance(values, dict):
            return values
        return {name: value for name, value in values.items() if not cls._is_harmless(name, value)}

    @classmethod
    def _is_harmless(cls, name: str, value: object) -> bool:
        """Whether a key of another class says what this one takes for granted."""
        other = None if name in cls.model_fields or name not in cls.harmless_keys else cls.homes().get(name)
        return other is not None and _is_default(cls.of_kind(other), name, value)

    @model_validator(mode="after")
    def _class_takes_the_values(self) -> Self:
        if self.made_from is not None:
            self.check_values()
        return self

    @classmethod
    def choice(cls) -> str:
        """The key that names the class, and its value."""
        return f"{cls.naming_key} = {cls.model_fields[cls.naming_key].default!r}"

    def check_values(self) -> None:
        """Raise CaseError if the class refuses the values; files are not read for that."""
        if not any(isinstance(value, TimeTableKeys) and value.file for value in self.__dict__.values()):
            self.build()

    def build(self, **known: Any) -> Any:
        """Make the object; arguments that are known otherwise replace those of the case.

        Raises
        ------
        CaseError
            If the class refuses the values, or a table cannot be read; the message begins with the key.
        """
        assert self.made_from is not None
        try:
            return self.made_from(**self.arguments() | known)
        except CaseError:
            raise
        except (ValueError, TypeError, ArithmeticError) as error:
            raise CaseError(self.in_words_of_the_case(str(error))) from None

    def arguments(self) -> dict[str, Any]:
        """Arguments of the class."""
        assert self.made_from is not None
        names = {field.name for field in dataclasses.fields(self.made_from)} & set(type(self).model_fields)
        values = {name: getattr(self, name) for name in names}
        for name, value in values.items():
            if isinstance(value, TimeTableKeys):
                with within(name):
                    values[name] = value.table()
        return values

    def in_words_of_the_case(self, text: str) -> str:
        """Message of the class with what the case can add: the class that refuses, and the meaning of the key."""
        name, _, _ = text.partition(":")
        field = type(self).model_fields.get(name)
        if field is None:
            return text
        for vague in checks.VAGUE_REMEDIES:
            text = text.removesuffix(f"; {vague}")
        if ": expected one of" in text:
            before, sign, after = text.rpartition(", got ")
            remedy = "" if ";" in after else "; choose one of them"
            return f"{before} with {self.choice()}{sign}{after}{remedy}"
        if ";" in text:
            return text
        return f"{text}; write the {meaning(name, field)}"


@contextmanager
def by_keys() -> Iterator[None]:
    """Put what is wrong with an argument of a run by the key of the case that sets it."""
    try:
        yield
    except InputError as error:
        keys = {"time_step": "solver.time_step", "method": "solver.method", "interval": "loop.interval"}
        parts = [problem.partition(":") for problem in error.problems]
        told = ("".join((keys.get(name, name), *rest)) for name, *rest in parts)
        raise type(error)(*told) from None


@contextmanager
def within(name: str) -> Iterator[None]:
    """Put the name of a section or key in front of what is wrong inside it."""
    try:
        yield
    except InputError as error:
        raise CaseError(*error.problems).behind(f"{name}.") from None


def keys_of(
    target: type, omitted: Sequence[str] = (), optional: Sequence[str] = (), demanded: Sequence[str] = ()
) -> dict[str, Any]:
    """Keys of a section for the fields of a dataclass, as `pydantic.create_model` takes them."""
    try:
        texts, hints, keys = docstrings.field_texts(target), get_type_hints(target), {}
    except Exception as error:  # annotations may hold anything that a class's author wrote
        text = f"{target.__name__}: cannot read the types of its fields ({type(error).__name__}: {error})"
        raise InputError(f"{text}; import their names at run time too") from None
    for field in dataclasses.fields(target):
        if not field.init or field.name in omitted:
            continue
        needed = field.name in demanded or field.default is field.default_factory is dataclasses.MISSING
        try:
            kind, example = value_type(hints[field.name])
        except TypeError as error:
            if not needed:
                continue  # Python alone can give it
            text = f"{target.__name__}: expected {field.name} to be numbers, texts or true and false, alone or in lists"
            raise InputError(f"{text}, got {error}; a field of another type needs a default, and is no key") from None
        given: dict[str, Any] = {}
        if field.name in optional:
            kind, given["default"] = kind | None, None
        elif field.default is not dataclasses.MISSING and not needed:
            given["default"], example = field.default, example if field.default in (None, ()) else field.default
        elif not needed:
            given["default_factory"] = field.default_factory
        words = docstrings.short(texts.get(field.name, "")) or field.name.replace("_", " ")
        if kind is Flag:
            words = f"choice true or false: {words}"
        keys[field.name] = (kind, Field(description=words, examples=[example], **given))
    return keys


def section_of(target: type, omitted: Sequence[str] = ()) -> type[Section]:
    """Section of one class, which needs no name for it."""
    return create_model(target.__name__, __base__=Section, __doc__=target.__doc__, **keys_of(target, omitted))


class Built(Section):
    """Section of one class, `section_of`, that is checked by making the object."""

    target: ClassVar[type]

    @model_validator(mode="after")
    def _class_takes_the_values(self) -> Self:
        try:
            self.build()
        except InputError as error:
            raise CaseError(*error.problems) from None
        return self

    def build(self) -> Any:
        """Make the object."""
        return self.target(**self.model_dump())


@cache
def _section(base: type[Chosen], kind: str, target: type) -> Any:
    """Section of a class among those that a base chooses from."""
    bases = base.parts_for(kind, target)
    taken = [name for part in bases for name in (*part.model_fields, *part.omitted_fields)]
    taken += base.unused_fields(target)
    keys: dict[str, Any] = {
        base.naming_key: (Literal[kind], Field(default=kind, description=base.registry.role, examples=[kind]))
    }
    keys |= keys_of(target, taken, bases[0].optional_keys, base.needed_keys(target))
    section = create_model(target.__name__, __base__=bases, __doc__=target.__doc__, **keys)
    made: Any = section  # type checkers do not know the parents of a class made on the fly
    made.made_from, made.origin_section = target, base
    return made


def _is_default(section: type[Section], name: str, value: object) -> bool:
    default = section.model_fields[name].default
    return value == default or (isinstance(value, list) and tuple(value) == default)
