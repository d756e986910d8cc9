"""`tautflex tune`: tensions that give wanted natural frequencies."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from tautflex.cli.cards import show_tuning
from tautflex.cli.options import Answer, CaseFile, Force, Overrides, about, command, load, require_new_file
from tautflex.errors import CaseError
from tautflex.writing import write_text

if TYPE_CHECKING:
    from tautflex.case import Case


@command
def tune(
    case: CaseFile,
    /,
    *,
    frequency: Annotated[
        list[float],
        Parameter(name="--frequency", help="Wanted natural frequency [Hz]; twice scales x and y apart."),
    ],
    mode: Annotated[
        list[str] | None,
        Parameter(name="--mode", help="Mode that shall have it: its number from 1, or its half-waves, such as 1,1."),
    ] = None,
    output: Annotated[Path | None, Parameter(name=["-o", "--output"], help="File for the tuned case.")] = None,
    force: Force = False,
    override: Overrides = None,
) -> Answer:
    """Scale the cable tensions until chosen natural frequencies hit their targets.

    Example: tautflex tune m2.toml --frequency 1.0 -o tuned.toml
    """
    numbers = [_mode(text) for text in mode] if mode else list(range(1, len(frequency) + 1))
    if not 1 <= len(frequency) <= 2 or len(numbers) != len(frequency):
        text = f"--frequency, --mode: expected one or two pairs, got {len(frequency)} and {len(numbers)}"
        raise CaseError(f"{text}; give one --mode per --frequency")
    loaded = load(case, override)
    if loaded.cables is None or loaded.edge_cords is not None:
        text = f"{case}: membrane.edges: expected 'cables', got {loaded.membrane.edges!r}"
        raise CaseError(f"{text}; tuning scales cable tensions, here choose membrane.stress_x and stress_y")
    own = [name for name, one in (loaded.mesh.sections or {}).items() if one.tension or one.stress_x or one.stress_y]
    if loaded.cables.pretension_x is None or loaded.cables.pretension_y is None or own:
        text = f"{case}: cables.pretension_x and pretension_y: expected all tension stated there, got some elsewhere"
        raise CaseError(f"{text}; state it there, tuning scales these two")
    if output is not None:
        require_new_file(output, force=force)

    from tautflex.case.build import build_model
    from tautflex.case.reading import changed_text
    from tautflex.solvers.modal.tuning import tune_pretension

    with about(case):
        result = tune_pretension(build_model(loaded), frequencies=frequency, modes=numbers)
    changes = _scaled(loaded, float(result.scale_x), float(result.scale_y))
    answer: dict[str, Any] = {
        **changes["cables"],
        "frequencies": result.frequencies,
        "modes": list(result.modes),
        "mesh_errors": [None if math.isnan(error) else float(error) for error in result.mesh_errors],
        "warnings": list(result.warnings),
        "files": {},
    }
    if output is not None:
        write_text(output, changed_text(case, override or (), changes, output.parent))
        answer["files"] = {"case": output}
    return Answer(answer, partial(show_tuning, case, answer))


def _mode(text: str) -> int | tuple[int, int]:
    """A mode's number, or its half-waves along x and y."""
    try:
        numbers = [int(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, 2):
        raise CaseError(f"--mode: expected a number such as 1, or half-waves such as 1,1, got {text!r}")
    return numbers[0] if len(numbers) == 1 else (numbers[0], numbers[1])


def _scaled(case: Case, scale_x: float, scale_y: float) -> dict[str, dict[str, float]]:
    """Tensions of a case, scaled, and with them a film stress that the case states by itself."""
    assert case.cables is not None
    pull_x, pull_y = case.cables.pretensions
    changes = {"cables": {"pretension_x": pull_x * scale_x, "pretension_y": pull_y * scale_y}}
    if case.membrane.stress_x is not None and case.membrane.stress_y is not None:
        changes["membrane"] = {
            "stress_x": case.membrane.stress_x * scale_x,
            "stress_y": case.membrane.stress_y * scale_y,
        }
    return changes
