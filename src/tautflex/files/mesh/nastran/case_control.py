"""What the case control of a Nastran deck selects: supports, multipoint constraints, masses, temperatures."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field

from tautflex.errors import MeshError
from tautflex.files.mesh.include import Line
from tautflex.files.mesh.raw import shorten

_SUBCASE = re.compile(r"\s*(?:SUBCASE|SUBCOM|SYMCOM|SYM|REPCASE|STEP)\b\s*=?\s*(\d{1,9})?", re.IGNORECASE)
_WORDS = {
    "SPC": r"SPC\s*(?:\([^)]*\))?",
    "MPC": r"MPC\s*(?:\([^)]*\))?",
    "NSM": r"NSM",
    "TEMPERATURE(LOAD)": r"TEMP(?:E\w*)?\s*(?:\(\s*(?:LOAD|BOTH)\s*\))?",
    "TEMPERATURE(INITIAL)": r"TEMP(?:E\w*)?\s*\(\s*INIT\w*\s*\)",
    "TEMPERATURE(MATERIAL)": r"TEMP(?:E\w*)?\s*\(\s*MATE\w*\s*\)",
    "DEFORM": r"DEFO\w*",
    "STATSUB": r"STATSUB\s*(?:\([^)]*\))?",
}
_CHOICE = {word: re.compile(rf"\s*{text}(?:\s*=\s*|\s+)(\w+)", re.IGNORECASE) for word, text in _WORDS.items()}
# What the subcase of STATSUB, a preload, hands on.
_PRELOADS = ("TEMPERATURE(LOAD)", "DEFORM")
_BEGIN = re.compile(r"\s*BEGIN\b[\s,=]*(?P<bulk>BULK\b)?\s*(?P<rest>[^\s$][^$]*)?", re.IGNORECASE)
_END = re.compile(r"\s*CEND\b", re.IGNORECASE)
_PARAMETER = re.compile(r"\s*PARAM\b", re.IGNORECASE)

Sets = Mapping[str, int | None]
Unions = Mapping[int, set[int]]


@dataclass(frozen=True)
class Selection:
    """Set of the chosen subcase for each word, None if it names none; ``stated`` if the deck has a case control."""

    stated: bool = False
    sets: Sets = field(default_factory=lambda: dict.fromkeys(_WORDS))

    def chosen(self, word: str, card: str, there: Collection[int], unions: Unions) -> set[int] | None:
        """Sets of a word that are selected, unions of others among them; None if the deck has no case control.

        Raises
        ------
        MeshError
            If a selected set is not ``there``, or none is selected of those that are.
        """
        number = self.sets[word]
        if number is None and self.stated and there:
            raise _unselected(word, card, there)
        if number is None or number == 0:
            return None if number is None else set()
        found = unions.get(number, set()) | ({number} & set(there))
        missing = sorted((found or {number}) - set(there))
        if missing:
            raise MeshError(f"expected set {missing[0]}, which {word} = {number} selects, got none; add its {card}")
        return found

    def only_or_chosen(self, word: str, card: str, there: Collection[int], unions: Unions) -> set[int]:
        """The same, and without a case control the only set; MeshError if there are several."""
        found = self.chosen(word, card, there, unions)
        if found is None and len(there) > 1:
            raise _unselected(word, card, there)
        return set(there) if found is None else found


def _unselected(word: str, card: str, there: Collection[int]) -> MeshError:
    return MeshError(
        f"case control: expected {word} = number for the sets {', '.join(map(str, there))} of {card}, got none; select "
        f"one, or none of them with {word} = 0"
    )


def bulk_and_selection(lines: Iterable[Line], step: int | None) -> tuple[list[Line], Selection]:
    """Bulk data, the whole deck if it is not marked, with parameters of the case control, and what ``step`` selects.

    Raises
    ------
    MeshError
        If subcases select different sets and ``step`` is None, or there is no subcase ``step``.
    """
    everything = list(lines)
    begin = next((k for k, (where, line) in enumerate(everything) if _begins(where, line)), -1)
    control = everything[: max(begin, 0)]
    end = next((k for k, (_, line) in enumerate(control) if _END.match(line)), None)
    parameters = [line for line in control[(end or 0) :] if _PARAMETER.match(line[1])]
    selection = Selection(end is not None, _selected(control[(end or 0) :], step))
    return [*parameters, *everything[begin + 1 :]], selection


def _begins(where: str, line: str) -> bool:
    """Whether the bulk data begins behind a line; MeshError if it is that of a part of the model."""
    found = _BEGIN.match(line)
    if found and (found["rest"] or not found["bulk"]):
        raise MeshError(
            f"{where}: expected BEGIN BULK, got {shorten(line.strip())}, a superelement or another part of the model, "
            "which is not read here; mesh the part with elements"
        )
    return bool(found)


def _selected(control: list[Line], step: int | None) -> Sets:
    overall: dict[str, int | None] = dict.fromkeys(_WORDS)
    subcases: list[tuple[int, dict[str, int | None]]] = []
    for where, line in control:
        begun = _SUBCASE.match(line)
        if begun:
            subcases.append((int(begun[1] or len(subcases) + 1), overall.copy()))
            continue
        for word, pattern in _CHOICE.items():
            choice = pattern.match(line.partition("$")[0])
            if choice is None:
                continue
            if not (choice[1].isascii() and choice[1].isdigit()) or len(choice[1]) > 9:
                raise MeshError(f"{where}: expected {word} = number, got {choice[1][:20]!r}; correct the line")
            (subcases[-1][1] if subcases else overall)[word] = int(choice[1])
    cases = subcases or [(1, overall)]
    for _, own in cases:
        before = next((sets for number, sets in cases if number == own["STATSUB"]), own)
        own |= {word: before[word] for word in _PRELOADS if own[word] is None}
    if step is not None:
        found = [own for number, own in cases if number == step]
        if len(found) != 1:
            listed = ", ".join(str(number) for number, _ in cases[:20])
            raise MeshError(f"expected step = number of one subcase ({listed}), got {step}; choose one of them")
        return found[0]
    for word in (word for word in _WORDS if word != "STATSUB"):
        if len({own[word] for _, own in cases}) > 1:
            listed = ", ".join(f"{number}: {word} = {own[word]}" for number, own in cases[:20])
            raise MeshError(
                f"expected subcases with the same supports, masses and temperatures, got {listed}; choose one with "
                "step = number"
            )
    return cases[0][1]
