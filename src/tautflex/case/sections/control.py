"""Sections of a case file that make a closed loop: hub, actuators, sensors, controller, loop."""

from __future__ import annotations

import dataclasses
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, SerializeAsAny, Strict, model_validator

from tautflex.case.messages import problem
from tautflex.case.options import Built, Chosen, section_of, within
from tautflex.case.registry import ACTUATORS, CONTROLLERS, SENSORS, TASKS
from tautflex.case.section import Positive, Section, Vector, key
from tautflex.case.sections.inputs import ChosenPoints, Placed
from tautflex.control.actuators.drive import Drive
from tautflex.errors import CaseError, InputError
from tautflex.mechanics.loads.inputs import Effect
from tautflex.motion.hub import FreeHub

_DRIVE = tuple(field.name for field in dataclasses.fields(Drive))


class Hub(section_of(FreeHub, ("inertia", "torque", "force", "breaks")), Built):  # type: ignore[misc] # its fields
    """Spacecraft body that is free to move and carries the structure; [maneuver] is then what laws follow."""

    target = FreeHub
    inertia: Vector | tuple[Vector, Vector, Vector] = key(
        "inertia about the hub's centre of mass in its own axes [kg m^2]: principal moments, or a tensor",
        (5.0, 5.0, 8.0),
    )


class Actuator(section_of(Drive), Placed):  # type: ignore[misc] # beside the keys of a class those of its drive
    """What the controller commands: wheels on the hub, or an effect on the structure, behind a drive."""

    registry = ACTUATORS

    @model_validator(mode="after")
    def _drive_takes_the_values(self) -> Self:
        """Its numbers are checked where the effect cannot be made without a structure, too."""
        self._behind(Drive)
        return self

    def _behind(self, drive: type[Drive], **known: Any) -> Drive:
        """Make a drive of the section's numbers; CaseError if it refuses them."""
        try:
            return drive(**known, **{name: getattr(self, name) for name in _DRIVE})
        except InputError as error:
            raise CaseError(self.in_words_of_the_case(str(error))) from None

    @classmethod
    def unused_fields(cls, target: type) -> tuple[str, ...]:
        """The signal, which the controller sets."""
        twice = {field.name for field in dataclasses.fields(target)} & set(_DRIVE)
        if twice and not issubclass(target, Drive):
            text = f"{target.__name__}: expected no field {min(twice)}, which is a key of every drive"
            raise InputError(f"{text}; rename it, so that it can be an actuator")
        return (target.signal, "breaks") if issubclass(target, Effect) else ()

    def arguments(self) -> dict[str, Any]:
        """Arguments of the class; an effect has no signal."""
        target, given = self.made_from, super().arguments()
        return given | {target.signal: None} if target is not None and issubclass(target, Effect) else given

    def build(self, **known: Any) -> Drive:
        """Make wheels, or an effect behind its drive."""
        made = super().build(**known)
        if isinstance(made, Drive):
            return made
        from tautflex.control.actuators.actuator import Actuator as Driven  # beside a section of the same name

        return self._behind(Driven, effect=made)


class Sensor(Placed):
    """What the controller is told."""

    registry = SENSORS

    @classmethod
    def parts_for(cls, kind: str, target: type) -> tuple[type[Chosen], ...]:
        """Points and cables may be chosen by names of a mesh file."""
        own = super().parts_for(kind, target)
        return (ChosenPoints, *own) if "points" in {field.name for field in dataclasses.fields(target)} else own


class Controller(Chosen):
    """Law from measurements to commands; the commands of several [[controller]] tables add."""

    registry = CONTROLLERS

    @classmethod
    def parts_for(cls, kind: str, target: type) -> tuple[type[Chosen], ...]:
        """A shaped law has a table of its own."""
        return (_Shaped, cls) if kind == "shaped-reference" else (cls,)

    @classmethod
    def one_or_more(cls, values: Any) -> Any:
        """Make the law of a table, or the laws of a list of tables."""
        if values is None or isinstance(values, Controller):
            return values
        if isinstance(values, dict):
            return cls.from_table(values)
        if not isinstance(values, list | tuple) or not values:
            raise problem(
                "a table of keys and values, or a list of them", values, "write for example kind = 'pd' in it"
            )
        laws = []
        for number, one in enumerate(values):
            if not isinstance(one, dict | Controller):
                raise problem("tables of keys and values", one, "write [[controller]] above each law")
            with within(f"{number}"):
                laws.append(cls.from_table(one))
        return tuple(laws)


class Task(Chosen):
    """What the controller is trained and judged on."""

    registry = TASKS


class FollowingLaw(Chosen):
    """Law behind a shaper, [controller.law]: one that follows the reference of the hub."""

    registry = CONTROLLERS

    @classmethod
    def kinds(cls) -> list[str]:
        """All that follow, but no second shaper."""
        laws: dict[str, Any] = dict(cls.registry)
        return [kind for kind, law in laws.items() if law.follows_reference and kind != "shaped-reference"]


class _Shaped(Chosen):
    """The law behind a shaper is a table of its own."""

    law: Annotated[SerializeAsAny[FollowingLaw], BeforeValidator(FollowingLaw.from_table)] = key(
        "law that follows the shaped reference, a [controller.law] table", {"kind": "pd", "stiffness": 30.0}
    )

    def arguments(self) -> dict[str, Any]:
        with within("law"):
            return super().arguments() | {"law": self.law.build()}


class Loop(Section):
    """When the controller acts, and what its sensors draw their noise from."""

    interval: Positive = key("time between two commands [s], a multiple of solver.time_step, > 0", default=0.01)
    seed: Annotated[int, Strict(), Field(ge=0)] = key("seed of the sensors' noise, >= 0", default=0)
