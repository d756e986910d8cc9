"""Installations that leave no room: a wheel run from a read-only place, without home, terminal or cache.

``python tools/installation.py [--install] [--only WORDS] [PYTHON ...]``: for each interpreter given, or this one, whose
packages are there; nothing is downloaded unless ``--install`` is given. ``--only "C locale"`` takes the cases whose
names have these words: each compiles everything, a minute or two on a quiet core. Prints a line per case.
"""

from __future__ import annotations

import argparse
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
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--install", action="store_true")
    parser.add_argument("--only", default="")
    parser.add_argument("python", nargs="*", default=[sys.executable])
    asked, failed = parser.parse_args(arguments), 0
    for python in asked.python:
        with tempfile.TemporaryDirectory(prefix="tautflex-installation-") as name:
            work = Path(name)
            work.chmod(0o755)
            found = unpacked(python, work, asked.install)
            if found is None:
                print(f"{python}: packages missing, left out (--install brings them)")
                continue
            for folder in ("home", "tmp", "code", "out"):
                (work / folder).mkdir()
                (work / folder).chmod(0o777)
            (work / "film.toml").write_text(CASE, encoding="utf-8")
            for number, (words, variables) in enumerate(environments(work).items()):
                if asked.only not in words:
                    continue
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
                if os.getuid() == 0:  # root writes anywhere but to what is mounted read-only
                    mount = f"mount --bind {found[1]} {found[1]} && mount -o remount,ro,bind {found[1]}"
                    command = ["unshare", "--mount", "sh", "-c", f'{mount} && exec "$@"', "sh", *command]
                done = subprocess.run(
                    command, env=variables | {"PYTHONPATH": str(found[1])}, cwd=work / "out", text=True,
                    stdin=subprocess.DEVNULL, capture_output=True, check=False,
                )  # fmt: skip
                good = done.returncode == 0 and "Traceback" not in done.stderr
                failed += not good
                print(f"{python}: {words}: {'works' if good else 'FAILS'}", *done.stderr.splitlines(), sep="\n    ")
    return failed


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
