"""Trials of a design: chosen one after another by Optuna, each with its own seed, and kept in its journal."""

from __future__ import annotations

import os
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from tautflex.case.schema import Case
from tautflex.errors import CaseError, MissingExtraError
from tautflex.study import axes, measures
from tautflex.study.axes import with_keys
from tautflex.study.reading import base_values
from tautflex.study.sections import Design, Limit, Study, Variable
from tautflex.study.store import Store, case_key

JOURNAL = "journal.log"
_NAME = "design"  # of the study in the journal


class Search:
    """Trials of a design in a folder.

    A trial depends on the seed, its number and the results of the trials before it alone, so that a search that was
    killed goes on as if nothing had happened.

    Parameters
    ----------
    study, design
        What is asked; the study has an engine already.
    directory
        Where the journal and the points are.

    Raises
    ------
    InputError
        If a variable or a measure is unknown, or the journal is that of another search.
    MissingExtraError
        If Optuna is not installed.
    """

    def __init__(self, study: Study, design: Design, directory: Path) -> None:
        try:
            import optuna
        except ImportError:
            text = "design: expected the package optuna, not installed"
            raise MissingExtraError(f"{text}; pip install 'tautflex[design]'") from None
        optuna.logging.set_verbosity(optuna.logging.WARNING)
        self._optuna: Any = optuna
        self._design = design
        self.base = base_values(study)
        self.store = Store(directory / "points", study.measures.records)
        self.names = tuple(dict.fromkeys((*design.minimize, *design.maximize, *design.constraints)))
        base = Case(**self.base)
        measures.check_names((*design.minimize, *design.maximize), base, "design.minimize")
        measures.check_names(tuple(design.constraints), base, "design.constraints")
        self._try_variables()
        self._study = self._opened(directory / JOURNAL)

    @property
    def finished(self) -> list[Any]:
        """Trials that have a result, or failed."""
        return [trial for trial in self._study.get_trials(deepcopy=False) if trial.state.is_finished()]

    def next_trials(self, most: int) -> list[Any]:
        """Trials that run at the same time: those that were chosen when a search ended, else new ones."""
        trials = self._study.get_trials(deepcopy=False)
        together = self._design.together
        first = len(trials) // together * together  # of the group that the next trial belongs to
        if first == len(trials) and any(not trial.state.is_finished() for trial in trials):
            first = len(trials) - together
        count = min(first + together, most) - len(trials)
        open_ones = [trial._trial_id for trial in trials if not trial.state.is_finished()]
        open_ones += [self._study.ask()._trial_id for _ in range(max(0, count))]
        chosen = []
        for number in open_ones:
            trial = self._optuna.trial.Trial(self._study, number)
            for place, (name, variable) in enumerate(self._design.variables.items()):
                self._study.sampler = self._sampler(trial.number, place)
                _suggest(trial, name, variable)
            chosen.append(trial)
        return chosen

    def keys_of(self, trial: Any) -> dict[str, Any]:
        """Keys of the case and their values in a trial."""
        found: dict[str, Any] = {}
        for name, variable in self._design.variables.items():
            found |= dict.fromkeys((name, *variable.also), trial.params[name])
        return found

    def case_of(self, number: int) -> Case:
        """Case of a trial."""
        return self._case(self.keys_of(self._study.get_trials(deepcopy=False)[number]))

    def tell(self, trial: Any, status: str, message: str) -> None:
        """Put the result of a trial into the journal."""
        found = self._measures(trial)
        wanted = [found.get(name) for name in (*self._design.minimize, *self._design.maximize)]
        lacking = [name for name in self.names if found.get(name) is None]
        if status == "completed" and lacking:
            status, message = "failed", f"the run tells no {lacking[0]}"
        trial.set_user_attr("status", status)
        trial.set_user_attr("message", message)
        if status != "completed":
            self._study.tell(trial, state=self._optuna.trial.TrialState.FAIL)
            return
        for name, limit in self._design.constraints.items():
            trial.set_constraint(name, _excess(limit, found[name] or 0.0))
        self._study.tell(trial, wanted)

    def dataset(self) -> xr.Dataset:
        """All trials as a Dataset, see `tautflex.design`."""
        trials, design = self.finished, self._design
        wanted = (*design.minimize, *design.maximize)
        rows = [self._measures(trial) for trial in trials]
        columns = {name: np.array([_number(row.get(name)) for row in rows]) for name in self.names}
        status = np.array([trial.user_attrs.get("status", "failed") for trial in trials], dtype=str)
        feasible = status == "completed"
        for name, limit in design.constraints.items():
            feasible &= np.array([_excess(limit, value) < 0.0 for value in columns[name]])
        found: dict[str, Any] = {}
        for name in self.names:
            found[name] = ("trial", columns[name], measures.words(name, measures.unit_of(name)))
        for name in design.variables:
            values = np.array([trial.params.get(name, "") for trial in trials])
            found[name] = ("trial", values, measures.words(name, axes.unit_of(name)))
        objective = np.stack([columns[name] for name in wanted], axis=1)
        found |= {
            "objective": (("trial", "measure"), objective),
            "feasible": ("trial", feasible),
            "status": ("trial", status),
            "message": ("trial", np.array([trial.user_attrs.get("message", "") for trial in trials], dtype=str)),
            "direction": ("measure", self._directions),
        }
        signs = np.array([1.0 if each == "minimize" else -1.0 for each in self._directions])
        numbers = [trial.number for trial in trials]
        best = [numbers[place] for place in _unbeaten(objective * signs, feasible)]
        return xr.Dataset(found, {"trial": numbers, "measure": list(wanted)}, {"title": "design", "best": best})

    @property
    def _directions(self) -> list[str]:
        """Where each objective is to go."""
        return ["minimize"] * len(self._design.minimize) + ["maximize"] * len(self._design.maximize)

    def _case(self, keys: dict[str, Any]) -> Case:
        """Case with some keys set; CaseError if it is not valid."""
        return Case(**with_keys(self.base, keys))

    def _measures(self, trial: Any) -> dict[str, float | None]:
        try:
            kept = self.store.read(case_key(self._case(self.keys_of(trial))))
        except (CaseError, KeyError):
            return {}
        return dict(kept["measures"]) if kept is not None else {}

    def _try_variables(self) -> None:
        """Raise CaseError for a key that no case has, and if neither end of the ranges is a valid case."""
        problems = list[CaseError]()
        for last in (False, True):
            keys: dict[str, Any] = {}
            for name, variable in self._design.variables.items():
                ends = variable.choices or ((int if variable.whole else float)(end) for end in _ends(variable))
                keys |= dict.fromkeys((name, *variable.also), list(ends)[-1 if last else 0])
            try:
                self._case(keys)
            except CaseError as error:
                problems.append(error)
        if len(problems) == 2 or any("unknown key" in str(error) for error in problems):
            raise problems[0].behind("design.variables.")

    def _opened(self, path: Path) -> Any:
        """Study in the journal, which a kill may have left with half a line at its end."""
        optuna = self._optuna
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists():
            content = path.read_bytes()
            if not content.endswith(b"\n"):
                os.truncate(path, content.rfind(b"\n") + 1)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            storage = optuna.storages.JournalStorage(optuna.storages.journal.JournalFileBackend(str(path)))
        design = self._design
        about = {"study_name": _NAME, "directions": self._directions, "load_if_exists": True}
        found = optuna.create_study(storage=storage, **about)
        asked = design.model_dump(mode="json", exclude={"trials"}) | {"base": case_key(Case(**self.base))}
        if found.user_attrs.setdefault("asked", asked) != asked:
            text = f"{path}: expected the journal of this search, got that of another [design] or case"
            raise CaseError(f"{text}; choose another folder, or remove the file")
        if "asked" not in found._storage.get_study_user_attrs(found._study_id):
            found.set_user_attr("asked", asked)
        return found

    def _sampler(self, trial: int, variable: int) -> Any:
        seed = np.random.SeedSequence([self._design.seed, trial, variable]).generate_state(1)[0]
        return self._optuna.samplers.TPESampler(seed=int(seed))


def _ends(variable: Variable) -> tuple[float, float]:
    assert variable.low is not None
    assert variable.high is not None
    return variable.low, variable.high


def _suggest(trial: Any, name: str, variable: Variable) -> None:
    """Choose the value of a variable, that of the journal if it has one."""
    if variable.choices is not None:
        trial.suggest_categorical(name, variable.choices)
        return
    low, high = _ends(variable)
    if variable.whole:
        trial.suggest_int(name, int(low), int(high), log=variable.spacing == "log")
    else:
        trial.suggest_float(name, low, high, log=variable.spacing == "log")


def _excess(limit: Limit, value: float) -> float:
    """How far a measure is beyond its limits, relative to the limit where that is not zero; negative inside."""
    found = []
    if limit.above is not None:
        found.append((limit.above - value) / (abs(limit.above) or 1.0))
    if limit.below is not None:
        found.append((value - limit.below) / (abs(limit.below) or 1.0))
    return max(found)


def _number(value: float | None) -> float:
    return np.nan if value is None else value


def _unbeaten(values: np.ndarray, feasible: np.ndarray) -> list[int]:
    """Rows that no other one is as good as in every column and better than in one; the first of equal ones."""
    found: list[int] = []
    for row in np.flatnonzero(feasible):
        others = values[feasible]
        beaten = ((others <= values[row]).all(axis=1) & (others < values[row]).any(axis=1)).any()
        same = (values[found] == values[row]).all(axis=1).any() if found else False
        if not beaten and not same:
            found.append(int(row))
    return found
