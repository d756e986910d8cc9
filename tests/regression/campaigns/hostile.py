"""Commands in hostile places: ``python tests/regression/campaigns/hostile.py``, as root, who may make small disks.

Names of commands may follow. Each runs twice at the same instant in one place, under a strange name, on another file
system, where a link leads nowhere, where nothing may be written, and in a folder that is removed in the middle: it does
what it was asked, or says in one line why not.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1])]

from processes import Asked, checked, commands, equal, left_alone  # noqa: E402

DONE, FAILED, BAD_INPUT = 0, 1, 2
STRANGE = "sp ace 'q' \"d\" ü€ [1] %s $HOME"


class Trial:
    """One command in one folder of trials, and what it says there."""

    def __init__(self, asked: Asked, whole: Path, folder: Path) -> None:
        self.asked, self.whole, self.folder, self.log = asked, whole, folder, folder / "log"

    def ended(self, *begun: subprocess.Popen[bytes]) -> list[int]:
        """Codes of commands, whose words are one line each if they failed."""
        codes = [each.wait() for each in begun]
        said = self.log.read_text(encoding="utf-8", errors="replace")
        assert "Traceback" not in said, said
        lines = [line for line in said.splitlines() if line.startswith("tautflex: error: ")]
        assert len(lines) == sum(code in (FAILED, BAD_INPUT) for code in codes), (codes, said)
        for each in begun:
            left_alone(each.pid)
        return codes

    def place(self, name: str) -> Path:
        """Folder of this trial."""
        self.log.write_bytes(b"")
        return self.folder / name

    def together(self) -> str:
        """Twice at the same instant."""
        place = self.place("together")
        codes = self.ended(*(self.asked.begun(place, self.log) for _ in range(2)))
        assert sorted(codes) in ([DONE, DONE], [DONE, BAD_INPUT]), (codes, self.log.read_text())
        equal(self.asked, place, self.whole)
        return f"{sorted(codes)}"

    def strange(self) -> str:
        """Under a name with all that shells, formats and patterns mind."""
        return self.elsewhere(self.place(STRANGE))

    def other_disk(self) -> str:
        """In memory, beside a file system on a disk."""
        self.place("")
        with tempfile.TemporaryDirectory(dir="/dev/shm") as name:
            return self.elsewhere(Path(name) / "made")

    def elsewhere(self, place: Path) -> str:
        """Somewhere, with the result that it has everywhere."""
        codes = self.ended(self.asked.begun(place, self.log))
        assert codes == [DONE], self.log.read_text()
        equal(self.asked, place, self.whole)
        return f"{codes}"

    def dangling(self) -> str:
        """Where the output is a link to nothing."""
        place = self.place("dangling")
        place.mkdir()
        (place / self.asked.output).symlink_to(place / "nowhere" / "deep")
        codes = self.ended(self.asked.begun(place, self.log, start=False))
        assert codes == [BAD_INPUT], (codes, self.log.read_text())
        assert [path.name for path in place.iterdir()] == [self.asked.output]
        return f"{codes}"

    def read_only(self) -> str:
        """On a disk that takes nothing."""
        place = self.place("disk")
        place.mkdir()
        subprocess.run(["mount", "-t", "tmpfs", "-o", "ro,size=1M", "tmpfs", str(place)], check=True)
        try:
            codes = self.ended(self.asked.begun(place, self.log, start=False))
        finally:
            subprocess.run(["umount", str(place)], check=True)
        assert codes == [BAD_INPUT], (codes, self.log.read_text())
        return f"{codes}"

    def removed(self) -> str:
        """In a folder that somebody removes meanwhile."""
        codes = list[int]()
        for part in (0.5, 0.7, 0.9):
            place = self.place("removed")
            process = self.asked.begun(place, self.log)
            with suppress(subprocess.TimeoutExpired):
                process.wait(part * self.asked.length)
            for _ in range(100):  # until it is gone though files are being made in it
                shutil.rmtree(place, ignore_errors=True)
                if not place.exists():
                    break
            codes += self.ended(process)
            if (place / self.asked.output).exists():
                checked(self.asked, place, self.whole)
            shutil.rmtree(place, ignore_errors=True)
        assert set(codes) <= {DONE, FAILED, BAD_INPUT}, (codes, self.log.read_text())
        return f"{codes}"


def campaign(*only: str) -> None:
    """Try every place with every command."""
    failures = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        known = commands(folder)
        for kind in only or known:
            asked, whole = known[kind], folder / "whole" / kind
            begun = time.perf_counter()
            assert asked.begun(whole, folder / "log").wait() == DONE, (folder / "log").read_text()
            asked.length = time.perf_counter() - begun
            own = folder / kind
            own.mkdir()
            trial = Trial(asked, whole, own)
            places: tuple[Callable[[], str], ...] = (
                trial.together, trial.strange, trial.other_disk, trial.dangling, trial.read_only, trial.removed
            )  # fmt: skip
            for place in places:
                try:
                    said = place()
                except AssertionError as error:
                    failures, said = failures + 1, f"WRONG {error}"
                print(f"{kind}, {place.__name__}: {said}", flush=True)  # noqa: T201
    sys.exit(min(failures, 1))


if __name__ == "__main__":
    campaign(*sys.argv[1:])
