"""What the case control of a Nastran deck says about supports and multipoint constraints."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

from tautflex.errors import MeshError
from tautflex.files.mesh.include import Line

_SUBCASE = re.compile(r"\s*(?:SUBCASE|SUBCOM|SYMCOM|SYM|REPCASE|STEP)\b\s*=?\s*(\d{1,9})?", re.IGNORECASE)
_CHOICE = {word: re.compile(rf"\s*{word}\s*(?:\([^)]*\))?\s*=\s*(\w+)", re.IGNORECASE) for word in ("SPC", "MPC")}
_BEGIN = re.compile(r"\s*BEGIN\b[\s,=]*BULK\b", re.IGNORECASE)
_END = re.compile(r"\s*CEND\b", re.IGNORECASE)


@dataclass(frozen=True)
class Selection:
    """Constraint set of the chosen subcase, None if it names none; ``stated`` if the deck has a case control.

    ``equations`` is the set of multipoint constraints, likewise.
    """

    number: int | None
    stated: bool
    equations: int | None = None


def bulk_and_selection(lines: Iterable[Line], step: int | None) -> tuple[list[Line], Selection]:
    """Bulk data section, the whole deck if it is not marked, and the constraint set that subcase ``step`` selects.

    Raises
    ------
    MeshError
        If subcases select different sets and ``step`` is None, or there is no subcase ``step``.
    """
    everything = list(lines)
    begin = next((k for k, (_, line) in enumerate(everything) if _BEGIN.match(line)), -1)
    control = everything[: max(begin, 0)]
    end = next((k for k, (_, line) in enumerate(control) if _END.match(line)), None)
    control = control[(end or 0) :]
    chosen = [_selected(control, step, word) for word in ("SPC", "MPC")]
    return everything[begin + 1 :], Selection(chosen[0], end is not None, chosen[1])


def _selected(control: list[Line], step: int | None, word: str) -> int | None:
    overall: int | None = None
    subcases: list[tuple[int, int | None]] = []
    for where, line in control:
        begun, choice = _SUBCASE.match(line), _CHOICE[word].match(line.partition("$")[0])
        if begun:
            subcases.append((int(begun[1] or len(subcases) + 1), overall))
        elif choice:
            if not choice[1].isdigit() or len(choice[1]) > 9:
                raise MeshError(f"{where}: expected {word} = number, got {choice[1][:20]!r}; correct the line")
            number = int(choice[1])
            if subcases:
                subcases[-1] = subcases[-1][0], number
            else:
                overall = number
    listed = ", ".join(f"{number}: {word} = {chosen}" for number, chosen in subcases[:20])
    if step is not None:
        found = [chosen for number, chosen in subcases or [(1, overall)] if number == step]
        if len(found) != 1:
            raise MeshError(f"expected step = number of one subcase ({listed or '1'}), got {step}; choose one of them")
        return found[0]
    if len({chosen for _, chosen in subcases}) > 1:
        raise MeshError(f"expected subcases with the same supports, got {listed}; choose one with step = number")
    return subcases[0][1] if subcases else overall
