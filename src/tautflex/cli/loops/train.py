"""`tautflex train`: a policy for the task of a case."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from tautflex.cli.cards import show_training
from tautflex.cli.options import Answer, CaseFile, Force, Overrides, about, command, load, new_file
from tautflex.cli.runs.run import progress_bar
from tautflex.errors import CaseError
from tautflex.writing import write_or_keep

_MOST = 10**6  # iterations, where the clock ends a training


@command
def train(
    case: CaseFile,
    /,
    *,
    output: Annotated[Path, Parameter(name=["-o", "--output"], help="File of the policy (.npz).")] = Path("policy.npz"),
    seconds: Annotated[float | None, Parameter(help="Time to train [s]; default: 300 unless --iterations.")] = None,
    iterations: Annotated[
        int | None, Parameter(help="Steps to train, in place of a time: the same everywhere.")
    ] = None,
    seed: Annotated[int, Parameter(help="Of all that is drawn.")] = 0,
    law: Annotated[
        str | None, Parameter(help="Linear law that the network learns behind: pd or none; default: pd on a hub.")
    ] = None,
    checkpoint: Annotated[
        Path | None, Parameter(help="File in which training is kept, and from which it goes on after an end or a kill.")
    ] = None,
    force: Force = False,
    override: Overrides = None,
) -> Answer:
    """Train a policy on the reduced model of a case: a small network behind a linear law.

    Gradients go through plant and policy (extras batch and control). `tautflex evaluate CASE --policy FILE` judges it
    on the full model, [controller] kind = "policy" flies it.

    Example: tautflex train slew.toml -o policy.npz --seconds 300 --seed 0
    """
    if iterations is not None and iterations < 1:
        raise CaseError(f"--iterations: expected a number >= 1, got {iterations}; ask for example --iterations 200")
    with new_file(output, force=force):
        loaded = load(case, override)

        from tautflex.learning.train import train as run

        with about(case), progress_bar() as progress:
            found = run(
                case=loaded,
                law=law,
                iterations=_MOST if iterations is None else iterations,
                seconds=300.0 if seconds is None and iterations is None else seconds,
                seed=seed,
                checkpoint=checkpoint,
                progress=progress,
            )
        write_or_keep(output, found.policy.save)
    answer = {
        "cost": found.cost,
        "start_cost": found.start_cost,
        "iterations": int(found.iterations[-1]),
        "skipped": found.skipped,
        "curve": {"iterations": found.iterations, "cost": found.costs},
        "digest": found.policy.digest,
        "files": {"policy": output},
    }
    return Answer(answer, partial(show_training, case, answer))
