"""Sections of a study file: each class is its own section, as those of a case file are."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, ConfigDict, Field, Strict, model_validator

from tautflex.case.messages import problem, show, unknown_key
from tautflex.case.schema import Case
from tautflex.case.section import Count, Flag, Number, Section, Text, key

_MOST = 10_000_000  # points


class Span(Section):
    """Evenly spaced values of an axis, both ends among them: { from = 0.5, to = 2.0, count = 4 }."""

    model_config = ConfigDict(populate_by_name=True)

    first: Number = Field(alias="from", description="first value", examples=[0.5])
    last: Number = Field(alias="to", description="last value", examples=[2.0])
    count: Count = key("number of values, >= 1", 4)
    spacing: Literal["linear", "log"] = key("whether differences or ratios are equal", default="linear")

    @model_validator(mode="after")
    def _can_be_spaced(self) -> Self:
        if self.spacing == "log" and not (self.first > 0.0 and self.last > 0.0):
            text = f"from: expected ends > 0 with spacing = 'log', got {self.first:g} and {self.last:g}"
            raise ValueError(f"{text}; take spacing = 'linear'")
        return self


def _axis(value: Any) -> Any:
    """Values of an axis: a list that is not empty, or a span."""
    if isinstance(value, dict):
        return Span(**value)
    if isinstance(value, Span):
        return value
    if not isinstance(value, list | tuple) or not len(value):
        got = "an empty list" if isinstance(value, list | tuple) else show(value)
        text = f"expected a list of values or {{ from, to, count }}, got {got}"
        raise ValueError(f"{text}; write for example [0.8, 1.0] or {{ from = 0.5, to = 2.0, count = 4 }}")
    return tuple(value)


Axis = Annotated[Span | tuple[Any, ...], BeforeValidator(_axis)]


class Measures(Section):
    """What is kept of every point."""

    names: tuple[Text, ...] = key(
        "numbers of the run's JSON by their dotted names; left out: all of them", ("probes.A.amplitude",), ()
    )
    records: Flag = key("choice true or false: keep the whole record of every run beside its numbers", default=False)


class Engine(Section):
    """What performs the points."""

    kind: Literal["auto", "serial", "batch", "dask"] = key(
        "way: 'serial', a pool of processes; 'batch', many reduced runs side by side on JAX; 'dask', a cluster; "
        "'auto', a batch of many points where it gives all measures, else processes",
        default="auto",
    )
    workers: Count | None = key("number of processes, one per core if not given", 2, None)
    scheduler: Text | None = key("address of a running Dask scheduler", "tcp://10.0.0.1:8786", None)

    @model_validator(mode="after")
    def _scheduler_belongs_to_dask(self) -> Self:
        if self.scheduler is not None and self.kind in ("serial", "batch"):
            text = f"scheduler: expected none with kind = {self.kind!r}, got {show(self.scheduler)}"
            raise ValueError(f"{text}; remove it or set kind = 'dask'")
        return self


class Variable(Section):
    """What a design may choose of a key of the case: a number in a range, or one of several values."""

    model_config = ConfigDict(populate_by_name=True)

    low: Number | None = Field(None, alias="from", description="lowest value", examples=[0.5])
    high: Number | None = Field(None, alias="to", description="highest value", examples=[2.0])
    choices: tuple[Any, ...] | None = key("list of values in place of a range", ("equal", "tributary"), None)
    spacing: Literal["linear", "log"] = key("scale on which a range is searched", default="linear")
    whole: Flag = key("choice true or false: whole numbers only", default=False)
    also: tuple[Text, ...] = key("keys that have the same value", ("cables.pretension_y",), ())

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        given = [name for name, value in (("from", self.low), ("to", self.high)) if value is not None]
        if (self.choices is None) != (len(given) == 2) or (self.choices is not None and given):
            raise ValueError("from: expected from and to, or choices; write for example { from = 0.5, to = 2.0 }")
        if self.low is not None and self.high is not None:
            if not self.low < self.high or (self.spacing == "log" and self.low <= 0.0):
                least = "0 < from < to" if self.spacing == "log" else "from < to"
                raise ValueError(f"from: expected {least}, got {self.low:g} and {self.high:g}; exchange or change them")
            if self.whole and (self.low != round(self.low) or self.high != round(self.high)):
                raise ValueError(f"from: expected whole ends, got {self.low:g} and {self.high:g}; round them")
        elif not self.choices or not all(isinstance(one, str | int | float) for one in self.choices):
            raise ValueError("choices: expected a list of numbers, texts or true and false; write ['a', 'b']")
        return self


class Limit(Section):
    """Range that a measure of a good design lies in."""

    above: Number | None = key("largest value that is too low", 0.0, None)
    below: Number | None = key("smallest value that is too high", 1.0, None)

    @model_validator(mode="after")
    def _limits_something(self) -> Self:
        if self.above is None and self.below is None:
            raise ValueError("above: missing, expected above, below or both; write for example { above = 0.0 }")
        if self.above is not None and self.below is not None and not self.above < self.below:
            raise ValueError(f"above: expected less than below = {self.below:g}, got {self.above:g}; exchange them")
        return self


class Design(Section):
    """Search for the best values of keys."""

    variables: dict[str, Annotated[Variable, BeforeValidator(Variable.from_table)]] = key(
        "table of keys of the case and what they may be", {"maneuver.duration": {"from": 0.5, "to": 2.0}}
    )
    minimize: tuple[Text, ...] = key("measures that should be small", ("probes.A.amplitude",), ())
    maximize: tuple[Text, ...] = key("measures that should be large", ("natural_frequencies.0",), ())
    constraints: dict[str, Annotated[Limit, BeforeValidator(Limit.from_table)]] = key(
        "table of measures and their limits", {"prestress.min_principal_resultant": {"above": 0.0}}, {}
    )
    trials: Count = key("number of points that are tried", default=50)
    together: Count = key("number of points that are chosen, and run, at the same time", default=1)
    seed: Annotated[int, Strict(), Field(ge=0)] = key("of what is drawn", default=0)

    @model_validator(mode="after")
    def _has_a_purpose(self) -> Self:
        if not self.variables:
            raise problem("at least one variable", {}, "add for example [design.variables]")
        wanted = (*self.minimize, *self.maximize)
        if not wanted or len(set(wanted)) < len(wanted):
            text = "minimize: expected measures, each once in minimize or maximize"
            raise ValueError(f"{text}, got {show(list(wanted))}; write for example minimize = ['surface.rms_max']")
        return self


class Study(Section):
    """A case and what varies in it: the content of a study file.

    Parameters
    ----------
    base
        Case, or name of its file; in a study file relative to that.
    axes
        Dotted key of the case -> its values, a list or a `Span` (``{"from": 0.5, "to": 2.0, "count": 4}``).
    zip
        Groups of axes that change together.
    measures, engine, design
        See `tautflex keys study`.

    Raises
    ------
    CaseError
        If a key is unknown, missing or unusable.

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.Study(base="m2.toml", axes={"maneuver.duration": [0.5, 1.0, 2.0]}).count
    3
    """

    schema_number: Literal[1] = Field(default=1, alias="schema", description="version of the format", examples=[1])
    base: Case | Text | Path = key("name of the case file, relative to the study", "m2.toml")
    zip: tuple[tuple[Text, ...], ...] = key(
        "list of groups of axes that change together", (("cables.pretension_x", "cables.pretension_y"),), ()
    )
    axes: dict[str, Axis] = key(
        "table of keys of the case and their values: a list or { from, to, count }", {"maneuver.duration": (0.5, 1)}, {}
    )
    measures: Annotated[Measures, BeforeValidator(Measures.from_table)] = key("[measures] section", default=Measures())
    engine: Annotated[Engine, BeforeValidator(Engine.from_table)] = key("[engine] section", default=Engine())
    design: Annotated[Design | None, BeforeValidator(Design.from_table)] = key("[design] section", None, None)

    @property
    def lengths(self) -> dict[str, int]:
        """Number of values of each axis."""
        return {name: axis.count if isinstance(axis, Span) else len(axis) for name, axis in self.axes.items()}

    @property
    def groups(self) -> tuple[tuple[str, ...], ...]:
        """Axes that change together, in the order of the file; most are alone."""
        together = {name: group for group in self.zip for name in group}
        return tuple(dict.fromkeys(together.get(name, (name,)) for name in self.axes))

    @property
    def count(self) -> int:
        """Number of points."""
        total = 1
        for group in self.groups:
            total *= self.lengths[group[0]]
        return total

    @model_validator(mode="after")
    def _groups_are_of_axes(self) -> Self:
        lengths = self.lengths
        named = [name for group in self.zip for name in group]
        for name in named:
            if name not in lengths:
                raise ValueError(f"zip.{name}: {unknown_key(name, list(self.zip[0]), lengths)}")
            if named.count(name) > 1:
                raise ValueError(f"zip: expected each axis once, got {name!r} twice; remove one")
        for group in self.zip:
            if len({lengths[name] for name in group}) > 1:
                told = ", ".join(f"{lengths[name]} of {name}" for name in group)
                raise ValueError(f"zip: expected equally many values of axes that change together, got {told}")
        for name in lengths:
            inside = next((other for other in lengths if other.startswith(f"{name}.")), None)
            if inside is not None:
                raise ValueError(f"axes.{inside}: expected no axis inside another, got one of {name}; remove one")
        if self.count > _MOST:
            raise ValueError(f"axes: expected at most {_MOST} points, got {self.count}; take fewer values")
        return self
