"""Commands on a disk that fills up: ``python tests/regression/campaigns/full_disk.py 20``, as root, who may make
small disks; names of commands may follow.

For each command and fill level there is an old result on a disk with less or more room for the new one. The command
ends in one line or well, and what has a result's name is whole.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1])]

from kills import Command, commands, compare, ended, look  # noqa: E402

from tautflex.cli import main  # noqa: E402


def asked(folder: Path) -> dict[str, Command]:
    """What is run."""
    known = commands(folder)
    modes = Command(("modes", str(folder / "film.toml"), "-n", "4"), 0.0)
    return {"run": known["run"], "sweep": known["sweep"], "export vtu": known["export vtu"], "modes": modes}


def full(kind: str, command: Command, whole: Path, disk: Path, share: float) -> int:
    """Exit code of a command beside an old result, where there is room for a share of a new one."""
    size = sum(path.stat().st_size for path in whole.rglob("*") if path.is_file())
    subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={6 * size + 2**20}", "tmpfs", str(disk)], check=True)
    try:
        place, log = disk / kind, disk.parent / "log"
        shutil.copytree(whole, place, ignore=shutil.ignore_patterns("points"))
        room = shutil.disk_usage(disk).free - int(share * size)
        with (disk / "filler").open("wb") as file:
            file.write(bytes(room))
        log.write_bytes(b"")
        code = ended(command.perform(place, log, *command.anew))
        said = log.read_text(encoding="utf-8")
        assert code in (0, 1), (kind, share, code, said)
        assert "Traceback" not in said, (kind, share, said)
        look(place)
        shutil.rmtree(place / "points", ignore_errors=True)
        for path in place.glob(".tautflex*"):  # what it could not go on from
            shutil.rmtree(path) if path.is_dir() else path.unlink()
        shutil.copytree(whole, disk.parent / "compared", ignore=shutil.ignore_patterns("points"))
        compare(place, disk.parent / "compared")
        return code
    finally:
        shutil.rmtree(disk.parent / "compared", ignore_errors=True)
        subprocess.run(["umount", str(disk)], check=True)


def campaign(levels: int, *only: str) -> dict[str, int]:
    """How often each command came to what end."""
    seen = dict[str, int]()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        tempfile.tempdir = str(folder / "elsewhere")  # where results are kept that have no room
        for made in ("elsewhere", "disk"):
            (folder / made).mkdir()
        for kind, command in asked(folder).items():
            whole = folder / "whole" / kind
            assert main([*command.arguments, "-o", str(whole)]) == 0  # children find here what is loaded and compiled
            if only and kind not in only:
                continue
            for level in range(levels):
                share = 1.5 * (level + 0.5) / levels
                code = full(kind, command, whole, folder / "disk", share)
                seen[f"{kind} {code}"] = seen.get(f"{kind} {code}", 0) + 1
                print(f"{kind}, room for {share:.0%}: {code}", flush=True)  # noqa: T201
    return seen


if __name__ == "__main__":
    print(json.dumps(campaign(int((sys.argv[1:] or ["20"])[0]), *sys.argv[2:]), indent=1))  # noqa: T201
