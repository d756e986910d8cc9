"""What runs share whose cases differ in motion, damping and steps alone: the prestressed structure, reduced or not."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from tautflex._version import __version__
from tautflex.case import build
from tautflex.case.options import within
from tautflex.case.schema import Case
from tautflex.control.actuators.actuator import Actuator
from tautflex.mechanics.loads.inputs import TimeInput
from tautflex.reduction.polynomial.model import ReducedModel, reduce
from tautflex.solvers.modal.natural import Modes, solve_modes
from tautflex.solvers.static.prestress import PrestressedState

MODE_COUNT = 10
_PACKAGE = Path(__file__).parent.parent
# Rooms that only look at finished runs; everything else may have had a hand in one.
_ONLOOKERS = ("cli", "plot")
# Sections that neither the prestressed structure nor a reduced model of it depends on.
_LATER = {"maneuver", "damping", "coupling", "solver", "hub", "sensors", "controller", "task", "loop", "output"}


@dataclass(frozen=True)
class Prepared:
    """What `prepare` makes of a case.

    Parameters
    ----------
    state
        Prestressed state, with the tendons of inputs and actuators.
    inputs
        What acts on the structure in time.
    reduced
        Reduced model of the state for these inputs and, in a closed loop, the actuators; None without [reduction].
    """

    state: PrestressedState
    inputs: tuple[TimeInput, ...]
    reduced: ReducedModel | None

    @cached_property
    def frequencies(self) -> tuple[float, ...]:
        """Natural frequencies of the `lowest_modes` [Hz]."""
        return tuple(map(float, lowest_modes(self.state).frequencies))

    @property
    def plant(self) -> PrestressedState | ReducedModel:
        """What is simulated."""
        return self.reduced or self.state


def prepare(
    case: Case, state: PrestressedState | None = None, progress: Callable[[float, str], None] | None = None
) -> Prepared:
    """Make everything of a case that `structure_key` tells from others; a state that is known is not made again.

    Raises
    ------
    InputError
        If a part of the case does not fit its structure.
    """
    state = build.build_state(case) if state is None else state
    inputs = build.build_inputs(case, state)
    if case.reduction is None:
        return Prepared(state, tuple(inputs), None)
    if progress is not None:
        progress(0.0, "reduced model")
    drives = build.build_actuators(case, state) if case.controller is not None else {}
    effects = [drive.effect for drive in drives.values() if isinstance(drive, Actuator)]
    return Prepared(state, tuple(inputs), reduced_model(case, state, [*inputs, *effects]))


def reduced_model(case: Case, state: PrestressedState, loads: Sequence[TimeInput]) -> ReducedModel | None:
    """Reduced model that a case asks for, which knows some inputs and effects; None without [reduction]."""
    if case.reduction is None:
        return None
    with within("reduction"):
        return reduce(state, case.reduction.build(), inputs=loads)


def lowest_modes(state: PrestressedState) -> Modes:
    """Natural modes that go with the results of a run, `MODE_COUNT` at most."""
    return solve_modes(state, n=min(MODE_COUNT, len(state.model.free_dofs) - 1))


def structure_key(case: Case) -> str:
    """Hash of all that `prepare` depends on: equal keys, equal structures."""
    own = case.model_dump(mode="json", by_alias=True, exclude=_LATER)
    return digest([own, case.controller is not None, files_of(own)])


def digest(content: Any) -> str:
    """Hash of nested tables, lists, numbers and texts."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def source_files() -> list[Path]:
    """Every file of the package that a run can depend on, sub-folders and data included, sorted."""
    files = [path for path in _PACKAGE.rglob("*") if path.suffix in (".py", ".toml")]
    return sorted(path for path in files if path.relative_to(_PACKAGE).parts[0] not in _ONLOOKERS)


@cache
def own_code() -> str:
    """Hash of version and sources: what another code left is not taken for what this one would."""
    files = {path.relative_to(_PACKAGE).as_posix(): path.read_text(encoding="utf-8") for path in source_files()}
    return digest([__version__, files])


def files_of(values: Any) -> dict[str, str]:
    """Hashes of the files that a case names by keys ``file``: their content is part of the case."""
    return {name: _file_digest(Path(name)) for name in sorted(set(_names(values)))}


def _names(values: Any) -> Iterator[str]:
    if isinstance(values, dict):
        for key, value in values.items():
            if key == "file" and isinstance(value, str):
                yield value
            else:
                yield from _names(value)
    elif isinstance(values, list | tuple):
        for value in values:
            yield from _names(value)


_DIGESTS: dict[tuple[str, int, int], str] = {}


def _file_digest(path: Path) -> str:
    """Hash of a file's content, read again when its time or size has changed; "" if it cannot be read."""
    try:
        found = path.stat()
        known = str(path), found.st_mtime_ns, found.st_size
        if known not in _DIGESTS:
            with path.open("rb") as file:
                _DIGESTS[known] = hashlib.file_digest(file, "sha256").hexdigest()
        return _DIGESTS[known]
    except OSError:
        return ""
