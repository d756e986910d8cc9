"""Timing in pairs: ours and a peer's run one after the other in alternating order, so that other load cancels."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from programs import Program, ProgramFailedError

Report = Callable[[str], None]
# A run of this many processor seconds averages the machine's moods itself and is not repeated.
LONG = 200.0


@dataclass
class Measured:
    """What one program did in one problem.

    Parameters
    ----------
    name
        Name of the program.
    result
        Arrays of its first run.
    seconds
        Processor seconds of each run.
    ratios
        Its seconds over ours, one per pair; empty for ourselves.
    """

    name: str
    result: dict[str, Any]
    seconds: list[float] = field(default_factory=list)
    ratios: list[float] = field(default_factory=list)

    @property
    def ratio(self) -> float:
        """Median ratio of the pairs."""
        return float(np.median(self.ratios)) if self.ratios else 1.0


def run_once(program: Program, problem: dict[str, np.ndarray], timeout: float | None = None) -> dict[str, Any]:
    """Solve a problem given as arrays; raises `ProgramFailedError`."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "problem.npz"
        np.savez(path, **problem)
        return program.run(path, Path(folder) / "result.npz", timeout)


def compare(
    ours: Program,
    peers: tuple[Program, ...],
    problem: dict[str, np.ndarray],
    rounds: int,
    report: Report,
    timeout: float | None = None,
    peers_problem: dict[str, np.ndarray] | None = None,
) -> list[Measured]:
    """Run ourselves and every peer in pairs.

    Parameters
    ----------
    ours, peers
        The programs; peers that fail are reported and left out.
    problem
        Arrays of the problem file.
    rounds
        Pairs per peer, one where the peer takes longer than `LONG`; which of the two goes first alternates.
    report
        Receives one line per run.
    timeout
        Allowed seconds of a run.
    peers_problem
        What the peers solve, if it is not the same.

    Returns
    -------
    list of Measured
        Ourselves first.
    """
    measured = {ours.name: Measured(ours.name, {})}
    failed: set[str] = set()

    def one(program: Program) -> float:
        given = problem if program is ours or peers_problem is None else peers_problem
        result = run_once(program, given, timeout)
        entry = measured.setdefault(program.name, Measured(program.name, result))
        entry.result = entry.result or result
        entry.seconds.append(float(result["seconds"]))
        report(f"  {program.name}: {entry.seconds[-1]:.2f} s of processor time")
        return entry.seconds[-1]

    if not peers:
        one(ours)
    for number in range(rounds):
        for peer in peers:
            if peer.name in failed or (number and measured[peer.name].seconds[-1] > LONG):
                continue
            # A failure of our own ends the comparison.
            mine = one(ours) if number % 2 == 0 else 0.0
            try:
                theirs = one(peer)
            except ProgramFailedError as failure:
                report(f"  {failure}; going on without it")
                failed.add(peer.name)
                continue
            mine = mine or one(ours)
            measured[peer.name].ratios.append(theirs / mine)
    return [entry for entry in measured.values() if entry.seconds]
