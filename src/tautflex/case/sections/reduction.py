"""Section of a case file that replaces the full model by a reduced one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field, Strict

from tautflex.case.section import Count, Section

if TYPE_CHECKING:
    from tautflex.case.schema import Case


class Reduction(Section):
    """Natural modes chosen by their participation in the load, in-plane companions; elastic laws only."""

    directions: Annotated[tuple[Literal["x", "y", "z", "rx", "ry", "rz"], ...], Field(min_length=1)] = Field(
        default=("z", "rx", "ry"),
        description="list of rigid accelerations that load the structure, of 'x', 'y', 'z', 'rx', 'ry', 'rz'",
        examples=[("rx",)],
    )
    count: Count | None = Field(
        default=None, description="number of natural modes, chosen by threshold if not given", examples=[12]
    )
    threshold: Annotated[float, Strict(), Field(gt=0.0, lt=1.0)] | None = Field(
        default=None, description="smallest part of a load's static energy that makes a mode count", examples=[5e-4]
    )
    candidates: Count | None = Field(
        default=None, description="number of lowest modes among which is chosen", examples=[100]
    )


def check_reduction(case: Case) -> None:
    """A reduced model has elastic laws, fixed steps and no base of its own to choose modes by order."""
    given = case.reduction
    if given is None:
        return
    if case.membrane.law != "elastic":
        text = f"reduction: expected membrane.law = 'elastic' with a [reduction], got {case.membrane.law!r}"
        raise ValueError(f"{text}; remove [reduction], or use hyper_reduce from Python")
    if case.cables is not None and case.cables.slack:
        text = "reduction: expected cables.slack = false with a [reduction], got true"
        raise ValueError(f"{text}; remove [reduction], or use hyper_reduce from Python")
    if case.solver.adaptive_tolerance is not None:
        text = f"reduction: expected no solver.adaptive_tolerance with it, got {case.solver.adaptive_tolerance:g}"
        raise ValueError(f"{text}; remove it, steps of a reduced model cost next to nothing")
    if given.count is not None and given.threshold is not None:
        text = f"reduction.threshold: expected no value beside count = {given.count}, got {given.threshold:g}"
        raise ValueError(f"{text}; keep one of the two")
