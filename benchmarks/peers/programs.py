"""The programs that are compared: where each lives, how it is called, and why it may be missing.

Every program is one small script, ``SCRIPT PROBLEM.npz RESULT.npz [OPTIONS]``, run by the interpreter of its own
environment on one core. Adding a peer means adding its script and one line here.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
ENVIRONMENTS = ROOT / ".peers"
ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
)


class ProgramFailedError(Exception):
    """A program gave no result; the message says why in one line."""


@dataclass(frozen=True)
class Program:
    """One program that solves a problem file.

    Parameters
    ----------
    name
        Name in tables.
    interpreter
        Python of the program's environment.
    script
        File beside this one.
    options
        What follows the two files on the command line.
    needs
        Module that must be importable.
    remedy
        How to install it.
    """

    name: str
    interpreter: Path
    script: str
    options: tuple[str, ...] = ()
    needs: str = "numpy"
    remedy: str = ""

    def missing(self) -> str | None:
        """Why the program cannot run, in one line, or None."""
        if not self.interpreter.exists():
            return f"{self.name}: no {_shown(self.interpreter)}; {self.remedy}"
        tried = subprocess.run([self.interpreter, "-c", f"import {self.needs}"], capture_output=True, check=False)
        if tried.returncode:
            return f"{self.name}: {_shown(self.interpreter)} cannot import {self.needs}; {self.remedy}"
        return None

    def run(self, problem: Path, result: Path, timeout: float | None = None) -> dict[str, Any]:
        """Solve a problem file on one core.

        Parameters
        ----------
        problem, result
            Files to read and to write.
        timeout
            Allowed seconds.

        Returns
        -------
        dict
            Arrays of the result file; ``details`` is decoded.

        Raises
        ------
        ProgramFailedError
            If the program fails or takes too long.
        """
        result.unlink(missing_ok=True)
        command = [str(self.interpreter), str(HERE / self.script), str(problem), str(result), *self.options]
        environment = {**os.environ, **ONE_THREAD}
        try:
            done = subprocess.run(
                [*_pinned(), *command], env=environment, capture_output=True, text=True, timeout=timeout, check=False
            )
        except subprocess.TimeoutExpired:
            raise ProgramFailedError(f"{self.name}: no result after {timeout:g} s") from None
        if done.returncode or not result.exists():
            lines = [line for line in (done.stderr or done.stdout).splitlines() if line.strip()] or ["no output"]
            raise ProgramFailedError(f"{self.name}: exit code {done.returncode}: {lines[-1].strip()}")
        with np.load(result) as file:
            values: dict[str, Any] = dict(file)
        values["details"] = json.loads(str(values["details"]))
        return values


def _shown(path: Path) -> str:
    return str(path.relative_to(ROOT)) if path.is_relative_to(ROOT) else str(path)


def _pinned() -> list[str]:
    """Prefix that keeps a command on one core, where the system has it."""
    if not hasattr(os, "sched_getaffinity"):
        return []
    return ["taskset", "--cpu-list", str(max(os.sched_getaffinity(0)))]


_SYSTEM = {
    "interpreter": Path("/usr/bin/python3"),
    "needs": "dolfinx",
    "remedy": "`make dolfinx` installs it (Debian, as root)",
}
_KRATOS = {
    "interpreter": ENVIRONMENTS / "kratos/bin/python",
    "needs": "KratosMultiphysics.LinearSolversApplication",
    "remedy": "`python benchmarks/peers/install.py` installs it",
}
_EXUDYN = {
    "interpreter": ENVIRONMENTS / "exudyn/bin/python",
    "needs": "exudyn",
    "remedy": "`python benchmarks/peers/install.py` installs it",
}
_SKFEM = {
    "interpreter": ENVIRONMENTS / "scikit-fem/bin/python",
    "needs": "skfem",
    "remedy": "`python benchmarks/peers/install.py` installs it",
}
_OURS = {"interpreter": Path(sys.executable), "needs": "tautflex"}

FILM = (
    Program("tautflex", script="film_tautflex.py", **_OURS),
    Program("DOLFINx, factors kept", script="film_dolfinx.py", options=("12",), **_SYSTEM),
    Program("DOLFINx, Newton", script="film_dolfinx.py", options=("0",), **_SYSTEM),
    Program("Kratos", script="film_kratos.py", **_KRATOS),
    Program("scikit-fem", script="film_skfem.py", options=("12",), **_SKFEM),
)
# Quadratic triangles: all but Kratos, which has no such membrane.
FILM_QUADRATIC = tuple(program for program in FILM if program.name != "Kratos")
SPINUP = (
    Program("tautflex", script="spinup_tautflex.py", options=("corotational",), **_OURS),
    Program("tautflex, von Karman", script="spinup_tautflex.py", options=("von-karman",), **_OURS),
    Program("Exudyn", script="spinup_exudyn.py", **_EXUDYN),
)
HUB = (
    Program("tautflex", script="hub_tautflex.py", options=("corotational",), **_OURS),
    Program("Exudyn", script="hub_exudyn.py", **_EXUDYN),
)
