"""State that a reduced run ended in, and another that goes on from it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tautflex.numeric import Array
from tautflex.reduction.marching.run import ReducedRun
from tautflex.solvers.remembering import Memory, copied, flat, nested
from tautflex.solvers.transient.accuracy.books import STRESS
from tautflex.solvers.transient.accuracy.energy import Energies
from tautflex.solvers.transient.restart.checkpoint import Checkpoint, fingerprint, structure_of
from tautflex.solvers.transient.restart.keeper import counted, recounted

# What of the work the next step depends on.
_KEPT = ("state", "inverse", "on_velocity", "on_displacement", "scale", "sizes", "counts")


def question(run: ReducedRun) -> dict[str, str]:
    """What the memory of a run belongs to: coordinates and damping are those of one model."""
    parts = {"coordinates": run.rom.basis.kept, "damping": run.arrays.damping, "mass": run.arrays.mass}
    return run.problem.memory_of | {name: repr((len(values), *fingerprint(values))) for name, values in parts.items()}


def resume(run: ReducedRun) -> bool:
    """Go on with the memory of another run, if it has one; accelerations take up what forces are others now."""
    initial = run.problem.initial
    if initial is None or not initial.remembers(question(run)):
        return False
    _recall(run, nested(initial.memory))
    return True


def kept(run: ReducedRun, seconds: float) -> dict[str, Array]:
    """Memory of a run that goes on in another process, which has taken some seconds."""
    memory = {"steps": _memory(run), "reached": run.reached, "before": run.before, "halvings": run.statistics.halvings}
    return flat(memory | {"seconds": seconds} | counted(run.statistics, run.warnings))


def go_on(run: ReducedRun, kept: Mapping[str, Array]) -> float:
    """Go on where another process kept this run; the seconds it had taken."""
    memory = nested(kept)
    run.reached = int(memory["reached"])
    _recall(run, memory["steps"])
    run.before, run.halvings = memory["before"], int(memory["halvings"])
    run.warnings = recounted(memory)[1]
    return float(memory["seconds"])


def _recall(run: ReducedRun, memory: Memory) -> None:
    for name, part in memory["work"].items():
        getattr(run.work, name)[:] = part
    run.books.recall(memory["books"])
    run.before, run.largest, run.first = run.work.counts.copy(), memory["largest"], Energies(**memory["energies"])
    run.first_stored = memory["first_stored"]
    run.meet(memory)
    if run.rom.in_elements:
        run.books.work[STRESS] += run.stored_now() - memory["stored"]


def _memory(run: ReducedRun) -> Memory:
    return {
        "work": copied({name: getattr(run.work, name) for name in _KEPT}),
        "books": run.books.memory(),
        "stored": run.stored_now(),
        "first_stored": run.first_stored,
        "energies": copied(run.first),
        "largest": run.largest,
        **run.pushed(),
    }


def final(run: ReducedRun, whole: bool) -> Checkpoint | None:
    """State to go on from; where not all steps were taken, the last one that was stored, which has no memory."""
    time, eta, rate, memory = run.time, run.work.q, run.work.v, Memory()
    if whole:
        memory = _memory(run)
    else:
        last = int(np.searchsorted(run.stored, run.reached, side="right")) - 1
        if last < 0:
            return run.problem.initial
        time, eta, rate = run.problem.instant(int(run.stored[last])), run.eta[last], run.rate[last]
    structure, (q, v) = structure_of(run.rom.state), run.motion_at(time, eta, rate)
    return Checkpoint(time, q, v, run.hub_at(time, eta, rate), structure, question(run), flat(memory))
