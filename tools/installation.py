"""Installations that leave no room: a wheel run from a read-only place, without home, terminal or cache.

``python tools/installation.py [PYTHON ...]``: for each interpreter of 3.11 to 3.13 (default: those on the path) whose
packages are there, or this one; nothing is downloaded unless ``--install`` is given. Prints a line per case.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HOME = Path(__file__).resolve().parent.parent
CASE = """schema = 1
[membrane]
length = 1.0
width = 0.8
thickness = 1e-4
youngs_modulus = 3.5e9
poisson_ratio = 0.34
density = 1530.0
edges = "fixed"
stress_x = 4000.0
stress_y = 3000.0
[mesh]
divisions = [3, 3]
[solver]
time_step = 0.01
end_time = 0.2
[maneuver]
kind = "stop"
rate = 0.5
duration = 0.1
"""
NOBODY = 65534


def environments(work: Path) -> dict[str, dict[str, str]]:
    """Environment variables of each case."""
    plain = {"PATH": os.environ["PATH"], "HOME": str(work / "home"), "TMPDIR": str(work / "tmp"), "LANG": "C.UTF-8"}
    bare = {"PATH": plain["PATH"], "TMPDIR": plain["TMPDIR"], "LC_ALL": "C", "PYTHONCOERCECLOCALE": "0"}
    return {
        "user's home": plain,
        "home that cannot be written": plain | {"HOME": "/proc/nowhere"},
        "no HOME, C locale": bare,
        "NUMBA_CACHE_DIR": bare | {"NUMBA_CACHE_DIR": str(work / "code")},
        "NUMBA_CACHE_DIR that cannot be written": bare | {"NUMBA_CACHE_DIR": "/proc/nowhere"},
    }


def unpacked(python: str, work: Path, install: bool) -> tuple[str, Path] | None:
    """Interpreter and the package as a wheel unpacks it, read-only; None where packages are missing."""
    place = work / "site"
    if install:
        subprocess.run([python, "-m", "venv", str(work / "venv")], check=True)
        python = str(work / "venv" / "bin" / "python")
        pinned = ["--constraint", str(HOME / "constraints.txt"), str(HOME)]
        subprocess.run([python, "-m", "pip", "install", "--quiet", *pinned], check=True)
        place = Path(
            subprocess.check_output(
                [python, "-c", "import sysconfig as s; print(s.get_path('purelib'))"], text=True
            ).strip()
        )
        shutil.rmtree(place / "tautflex" / "__pycache__", ignore_errors=True)
    else:
        if subprocess.run([python, "-c", "import numba, h5netcdf, cyclopts"], capture_output=True).returncode:
            return None
        shutil.copytree(HOME / "src" / "tautflex", place / "tautflex", ignore=shutil.ignore_patterns("__pycache__"))
    for folder in (place / "tautflex").rglob("*"):
        folder.chmod(0o555 if folder.is_dir() else 0o444)
    (place / "tautflex").chmod(0o555)
    place.chmod(0o555)
    return python, place


def main(arguments: list[str]) -> int:
    """Go through the matrix; the number of cases that failed."""
    install, given = "--install" in arguments, [each for each in arguments if each != "--install"]
    failed = 0
    for python in given or [sys.executable]:
        with tempfile.TemporaryDirectory(prefix="tautflex-installation-") as name:
            work = Path(name)
            work.chmod(0o755)
            found = unpacked(python, work, install)
            if found is None:
                print(f"{python}: packages missing, left out (--install brings them)")
                continue
            for folder in ("home", "tmp", "code", "out"):
                (work / folder).mkdir()
                (work / folder).chmod(0o777)
            (work / "film.toml").write_text(CASE, encoding="utf-8")
            for number, (words, variables) in enumerate(environments(work).items()):
                command = [
                    found[0],
                    "-m",
                    "tautflex",
                    "run",
                    str(work / "film.toml"),
                    "-o",
                    str(work / "out" / str(number)),
                    "--json",
                ]
                user = {"user": NOBODY, "group": NOBODY} if os.getuid() == 0 else {}
                done = subprocess.run(
                    command, env=variables | {"PYTHONPATH": str(found[1])}, cwd=work / "out", text=True,
                    stdin=subprocess.DEVNULL, capture_output=True, check=False, **user,
                )  # fmt: skip
                good = done.returncode == 0 and "Traceback" not in done.stderr
                failed += not good
                print(f"{python}: {words}: {'works' if good else 'FAILS'}", *done.stderr.splitlines(), sep="\n    ")
    return failed


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
