"""`tautflex evaluate`: laws and policies on the scenarios of a case's task."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from tautflex import compiling
from tautflex.cli.cards import show_evaluation
from tautflex.cli.options import (
    Answer,
    CaseFile,
    Overrides,
    ResultFolder,
    about,
    command,
    load,
    require_output_directory,
)
from tautflex.cli.runs.run import default_directory, progress_bar
from tautflex.errors import CaseError
from tautflex.files.transaction import publish, result_folder
from tautflex.writing import write_text


@command
def evaluate(
    case: CaseFile,
    /,
    *,
    law: Annotated[
        list[str] | None,
        Parameter(help="pd, lqg, tension, switching, none, joined with +, behind zv or zvd; case: its [controller]."),
    ] = None,
    policy: Annotated[list[Path] | None, Parameter(help="File of a trained policy (.npz); may be repeated.")] = None,
    budget: Annotated[float, Parameter(help="Time of plants for tuning each named law [s]; 0 tunes none.")] = 1500.0,
    plant: Annotated[
        list[str] | None, Parameter(help="full, reduced; may be repeated; default: both, for the gap.")
    ] = None,
    angles: Annotated[int, Parameter(help="Values of the task's first parameter.")] = 4,
    seeds: Annotated[int, Parameter(help="Seeds of the noise.")] = 2,
    workers: Annotated[int | None, Parameter(help="Processes; default: one per core.")] = None,
    output: ResultFolder = None,
    override: Overrides = None,
) -> Answer:
    """Judge laws on the full model: a grid of episodes, the same for all, with errors of the tension that none knows.

    Named laws are tuned on the reduced model first, all with the same budget. Each finished episode is kept in the
    directory, and an interrupted evaluation goes on there. Lower costs are better.

    Example: tautflex evaluate slew.toml --law pd --law zvd+pd --policy policy.npz -o judged
    """
    names, files = law or ([] if policy else ["pd"]), policy or []
    if len({*names, *(file.stem for file in files)}) < len(names) + len(files):
        raise CaseError("--law, --policy: expected different names, got one twice; leave it out or rename the file")
    loaded = load(case, override)
    directory = output if output is not None else default_directory(case)
    require_output_directory(directory)

    from tautflex.case.loop import build_law
    from tautflex.control.laws.policy import PolicyLaw
    from tautflex.files import netcdf
    from tautflex.learning.arena import Arena
    from tautflex.learning.judging.baselines import baseline
    from tautflex.learning.judging.evaluate import evaluate as judge
    from tautflex.learning.judging.evaluate import summary
    from tautflex.learning.judging.scenarios import scenarios_of
    from tautflex.learning.judging.tune import tune_law

    laws: dict[str, Any] = {}
    with result_folder(directory), about(case), progress_bar() as progress:
        compiling.say(progress, "preparing plant and laws ...")
        laws |= {file.stem: PolicyLaw(str(file)) for file in files}
        arena = Arena(loaded)
        for name in names:
            if name == "case":
                laws[name] = build_law(loaded, arena.plant("full", exact=False))
                continue
            laws[name] = baseline(name, arena)
            if budget > 0.0:
                laws[name] = tune_law(laws[name], arena, budget, progress=progress).law
        scenarios = scenarios_of(arena.task, angles, seeds=seeds)
        plants = tuple(plant or ("full", "reduced"))
        found = judge(
            laws,
            loaded,
            scenarios=scenarios,
            plants=plants,
            directory=directory / "episodes",
            workers=workers,
            progress=progress,
        )
        answer = {
            "laws": {name: told | {"law": repr(laws[name])} for name, told in summary(found).items()},
            "scenarios": len(scenarios),
            "failures": found.attrs["failures"],
            "files": {"evaluation": directory / "evaluation.nc", "summary": directory / "evaluation.json"},
        }

        def write(place: Path, final: Path) -> None:
            netcdf.save(found, place / "evaluation.nc")
            write_text(place / "evaluation.json", json.dumps(answer, default=str, indent=1))

        publish(directory, write)
    return Answer(answer, partial(show_evaluation, case, answer))
