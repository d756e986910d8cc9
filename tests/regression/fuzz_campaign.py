"""Feed damaged files to a reader and count what happens; each batch runs in a limited process of its own.

By hand: ``python tests/regression/fuzz_campaign.py abaqus --count 20000`` (targets: case, runs, abaqus, nastran,
gmsh, results). A batch that dies or hangs is reported with the seed it was at.
"""

from __future__ import annotations

import argparse
import json
import re
import signal
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from tautflex import read_mesh

sys.path.insert(0, str(Path(__file__).absolute().parents[1]))

import tautflex as tf
from regression import case_generator, mesh_files
from regression.mutations import mutated
from regression.rich_decks import ABAQUS, NASTRAN
from regression.small_decks import DECKS
from regression.small_result import result_files
from tautflex.case import parse_case, template
from verification.builders import antenna

M2_TEMPLATE = template("m2-nearest-node")

MEMORY = 2 * 1024**3  # [B] of address space, beside what a process holds that has read or run one of each kind
SLOW = 20.0  # [s] of computing one small file may take at most


@dataclass
class Outcome:
    """Count of inputs and what became of them."""

    inputs: int = 0
    accepted: int = 0
    refused: int = 0
    slowest: float = 0.0
    failures: list[str] = field(default_factory=list)

    def add(self, other: Outcome) -> None:
        self.inputs, self.accepted = self.inputs + other.inputs, self.accepted + other.accepted
        self.refused, self.slowest = self.refused + other.refused, max(self.slowest, other.slowest)
        self.failures += other.failures

    def __str__(self) -> str:
        return f"{self.inputs} inputs, {len(self.failures)} crashes"


@dataclass(frozen=True)
class Target:
    """A reader of files: suffix, valid samples, and the call that reads a path."""

    suffix: str
    samples: Callable[[], list[bytes]]
    read: Callable[[Path], object]
    binary: bool = False
    make: Callable[..., bytes] = mutated
    slow: float = SLOW


def _meshes(writer: Callable[..., str], suffix: str, *rich: str) -> Callable[[], list[bytes]]:
    """An antenna, decks with everything, and small ones, which are many a second."""

    def samples() -> list[bytes]:
        small = [re.sub(r"(?m)^\*?INCLUDE.*\n", "", one.text) for one in DECKS.values() if one.suffix == suffix]
        return [text.encode() for text in (writer(antenna((0.59, 1.0), (2, 2))), *rich, *(4 * small))]

    return samples


def built(path: Path) -> None:
    """Read a mesh, and make the structure of it where the file states all that it needs."""
    mesh = read_mesh(path)
    with suppress(tf.InputError):
        mesh.model()


def _cases() -> list[bytes]:
    return [M2_TEMPLATE.encode(), parse_case(M2_TEMPLATE).to_toml().encode(), PLAIN]


PLAIN = b"""schema = 1
[membrane]
length = 2.0
width = 1.0
thickness = 1e-4
youngs_modulus = 3.5e9
poisson_ratio = 0.34
density = 1530.0
edges = "fixed"
stress_x = 4e3
stress_y = 4e3
"""

TARGETS = {
    "case": Target(".toml", _cases, tf.load_case),
    "abaqus": Target(".inp", _meshes(mesh_files.abaqus, ".inp", ABAQUS), built),
    "nastran": Target(".bdf", _meshes(mesh_files.nastran, ".bdf", NASTRAN), built),
    "gmsh": Target(".msh", _meshes(mesh_files.msh, ".msh"), read_mesh),
    "runs": Target(".toml", case_generator.warm_up, case_generator.run, make=case_generator.generated, slow=10.0),
    "results": Target(".nc", result_files, tf.load, binary=True),
}


def attempt(target: Target, content: bytes, path: Path) -> bool:
    """Read ``content`` from ``path``: whether it is accepted; anything but a tautflex error comes through."""
    path.unlink(missing_ok=True)  # a new file, because HDF5 knows files it still holds open again
    path.write_bytes(content)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            target.read(path)
        except tf.TautflexError as error:
            problems = error.problems if isinstance(error, tf.InputError) else (str(error),)
            if not problems or any("\n" in problem or not problem for problem in problems):
                raise AssertionError(f"expected one line for every problem, got {error!s}") from error
            return False
    return True


def campaign(name: str, first: int, count: int, batch: int = 5000) -> Outcome:
    """Try the mutations ``first`` to ``first + count`` of a target, batch by batch."""
    total = Outcome()
    start = first
    while start < first + count:
        size = min(batch, first + count - start)
        outcome, reached = _run_batch(name, start, size)
        total.add(outcome)
        start = reached
    return total


def _run_batch(name: str, first: int, count: int) -> tuple[Outcome, int]:
    """Outcome of a batch in a child, and the seed to go on with: after the one at which it died, if it did."""
    command = [sys.executable, __file__, name, "--child", "--first", str(first), "--count", str(count)]
    died = ""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=60.0 + SLOW * count, check=False)
        lines, said = done.stdout, done.stderr
        if done.returncode:
            died = f"ended with status {done.returncode}: {said.strip()[-300:]}"
    except subprocess.TimeoutExpired as error:
        lines, died = (error.stdout or b"").decode(), "hung"
    records = [json.loads(line) for line in lines.splitlines() if line.endswith("}")]
    outcome = Outcome()
    for record in records:
        outcome.add(Outcome(**record))
    if died:
        outcome.add(Outcome(inputs=1, failures=[f"{name} seed {first + len(records)}: {died}"]))
    return outcome, first + outcome.inputs


def _child(name: str, first: int, count: int) -> None:
    """Try a range of seeds, one line of JSON each."""
    target = TARGETS[name]
    samples = target.samples()
    _limit_memory()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "input").with_suffix(target.suffix)
        for seed in range(first, first + count):
            outcome = Outcome(inputs=1)
            content = target.make(seed, samples, binary=target.binary)
            signal.setitimer(signal.ITIMER_PROF, target.slow)  # ends this process even inside a C library
            started = time.process_time()
            try:
                outcome.accepted = int(attempt(target, content, path))
                outcome.refused = 1 - outcome.accepted
            except BaseException as error:
                if isinstance(error, KeyboardInterrupt):
                    raise
                outcome.failures = [f"{name} seed {seed}: {type(error).__name__}: {str(error)[:200]}"]
            outcome.slowest = time.process_time() - started
            if outcome.slowest > target.slow:
                outcome.failures.append(f"{name} seed {seed}: took {outcome.slowest:.1f} s")
            sys.stdout.write(json.dumps(vars(outcome)) + "\n")
            sys.stdout.flush()


def _limit_memory() -> None:
    with suppress(ImportError):
        import resource

        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, hard))
        resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))


def main() -> int:
    """Run a campaign, or one batch of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", choices=TARGETS)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child:
        _child(given.target, given.first, given.count)
        return 0
    outcome = campaign(given.target, given.first, given.count)
    details = f"{outcome.accepted} accepted, {outcome.refused} refused, slowest {outcome.slowest:.2f} s"
    sys.stdout.write("\n".join([f"{given.target}: {outcome} ({details})", *outcome.failures[:40], ""]))
    return bool(outcome.failures)


if __name__ == "__main__":
    raise SystemExit(main())
