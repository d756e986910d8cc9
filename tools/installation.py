"""Installations that leave no room: a wheel run from a read-only place, without home, terminal or cache.

``python tools/installation.py [--install] [--keep FOLDER] [PYTHON ...]``: for each interpreter given, or this one,
whose packages are there; nothing is downloaded unless ``--install`` is given: then a wheel is built and installed into
an environment of its own. Each interpreter compiles everything once, a minute or two on a quiet core; the other cases
find that code but a function, which they have to compile and keep. In the folder that is kept, what works is not run
again. Prints a line per case.
"""

from __future__ import annotations

import argparse
import os
import pwd
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


ONE = "inertia._collect_moments*"  # the function that every case compiles


def environments(work: Path) -> dict[str, tuple[dict[str, str], Path]]:
    """Environment variables of each case, and where its compiled code goes."""
    plain = {"PATH": os.environ["PATH"], "HOME": str(work / "home"), "TMPDIR": str(work / "tmp"), "LANG": "C.UTF-8"}
    bare = {"PATH": plain["PATH"], "TMPDIR": plain["TMPDIR"], "LC_ALL": "C", "PYTHONCOERCECLOCALE": "0"}
    nowhere, own = "/proc/nowhere", Path(pwd.getpwuid(os.getuid()).pw_dir, ".cache", "numba")
    return {
        "user's home": (plain, work / "home" / ".cache" / "numba"),
        "home that cannot be written": (plain | {"HOME": nowhere}, work / "tmp" / f"tautflex-compiled-{os.getuid()}"),
        "no HOME, C locale": (bare, own),
        "NUMBA_CACHE_DIR": (bare | {"NUMBA_CACHE_DIR": str(work / "code")}, work / "code"),
        "NUMBA_CACHE_DIR that cannot be written": (bare | {"NUMBA_CACHE_DIR": nowhere}, own),
    }


def unpacked(python: str, work: Path, install: bool) -> tuple[str, Path] | None:
    """Interpreter and the package as a wheel unpacks it, read-only; None where packages are missing."""
    place = work / "site"
    if install:
        own = str(work / "venv" / "bin" / "python")
        if not Path(own).exists():
            subprocess.run([python, "-m", "venv", str(work / "venv")], check=True)
            subprocess.run([own, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", str(work), str(HOME)], check=True)
            (wheel,) = map(str, work.glob("tautflex-*.whl"))
            pinned = ["--constraint", str(HOME / "constraints.txt"), wheel]
            subprocess.run([own, "-m", "pip", "install", "--quiet", *pinned], check=True)
        found = subprocess.check_output([own, "-c", "import sysconfig as s; print(s.get_path('purelib'))"], text=True)
        python, place = own, Path(found.strip())
    elif not place.exists():
        if subprocess.run([python, "-c", "import numba, h5netcdf, cyclopts"], capture_output=True).returncode:
            return None
        shutil.copytree(HOME / "src" / "tautflex", place / "tautflex", ignore=shutil.ignore_patterns("__pycache__"))
    for folder in (place / "tautflex").rglob("*"):
        folder.chmod(0o555 if folder.is_dir() else 0o444)
    (place / "tautflex").chmod(0o555)
    place.chmod(0o555)
    return python, place


def seed(first: Path, place: Path) -> None:
    """Give a case the compiled code of the first one, but one function of it."""
    for source in first.rglob("*.nb*") if place != first else ():
        target = place / source.relative_to(first)
        target.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        if not source.match(ONE):
            shutil.copy2(source, target)


def works(python: str, site: Path, work: Path, variables: dict[str, str], place: Path) -> tuple[bool, list[str]]:
    """Whether a run of a case ends well and keeps its compiled code where it should, and what it said."""
    command = [python, "-m", "tautflex", "run", str(work / "film.toml"), "-o", str(work / "out"), "--json", "--force"]
    if os.getuid() == 0:  # root writes anywhere but to what is mounted read-only
        mount = f"mount --bind {site} {site} && mount -o remount,ro,bind {site}"
        command = ["unshare", "--mount", "sh", "-c", f'{mount} && exec "$@"', "sh", *command]
    done = subprocess.run(
        command, env=variables | {"PYTHONPATH": str(site)}, cwd=work, text=True,
        stdin=subprocess.DEVNULL, capture_output=True, check=False,
    )  # fmt: skip
    kept = any(place.rglob(ONE)) and not any(site.rglob("tautflex/**/*.nbi"))
    return kept and done.returncode == 0 and "Traceback" not in done.stderr, done.stderr.splitlines()


def matrix(python: str, work: Path, install: bool) -> int:
    """Go through the cases of an interpreter; the number of those that failed."""
    for folder in ("home", "tmp", "code"):
        (work / folder).mkdir(exist_ok=True)
    (work / "film.toml").write_text(CASE, encoding="utf-8")
    found = unpacked(python, work, install)
    if found is None:
        print(f"{python}: packages missing, left out (--install brings them)")
        return 0
    failed, first = 0, work / "home" / ".cache" / "numba"
    for number, (words, (variables, place)) in enumerate(environments(work).items()):
        mark = work / f"works-{number}"
        good, said = True, ["as before"]
        if not mark.exists():
            seed(first, place)
            good, said = works(*found, work, variables, place)
        if good:
            mark.touch()
        failed += not good
        print(f"{python}: {words}: {'works' if good else 'FAILS'}", *said, sep="\n    ", flush=True)
        for folder in first.iterdir() if not place.is_relative_to(work) else ():
            shutil.rmtree(place / folder.name, ignore_errors=True)
    return failed


def main(arguments: list[str]) -> int:
    """Go through the matrix; the number of cases that failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--install", action="store_true")
    parser.add_argument("--keep", type=Path)
    parser.add_argument("python", nargs="*", default=[sys.executable])
    asked, failed = parser.parse_args(arguments), 0
    with tempfile.TemporaryDirectory(prefix="tautflex-installation-") as name:
        for number, python in enumerate(asked.python):
            work = Path(asked.keep or name).absolute() / str(number)
            work.mkdir(parents=True, exist_ok=True)
            failed += matrix(python, work, asked.install)
    return failed


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
