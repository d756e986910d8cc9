"""Every line of a Gmsh mesh of format 2 or 4 counts: without it, or with a number changed (see `test_no_silent_loss`).

One process reads all the files, as Gmsh takes most of a second to start.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from regression import mesh_files
from regression.test_no_silent_loss import fingerprint
from tautflex import MeshError
from tautflex.files.mesh.gmsh import reader

pytestmark = [
    pytest.mark.campaign,
    pytest.mark.skipif(not mesh_files.gmsh_starts(), reason="needs Gmsh, of the extra tautflex[mesh]"),
]
SERVER = """
import sys
sys.path.insert(0, sys.argv[1])
import gmsh, numpy, _gmsh_worker
gmsh.initialize([], readConfigFiles=False, run=False, interruptible=False)
gmsh.option.setNumber("General.Terminal", 0)
for line in sys.stdin:
    mesh, arrays = line.strip().split("|")
    gmsh.clear()
    try:
        gmsh.merge(mesh)
        numpy.savez(arrays, **_gmsh_worker.collect(gmsh, numpy))
        print("done", flush=True)
    except Exception:
        print("refused", flush=True)
"""
FORMAT_2 = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
4
0 1 "support"
1 2 "cables"
1 3 "frame"
2 4 "membrane"
$EndPhysicalNames
$Nodes
8
1 0 0 0
2 1 0 0
3 1 1.25 0
4 0 1 0
5 2 0.5 0
6 -0.5 -0.5 0.25
7 -0.5 1.5 0.25
8 3 0.5 0
$EndNodes
$Elements
10
1 15 2 1 1 6
2 15 2 1 2 7
3 15 2 1 3 8
4 1 2 2 4 1 6
5 1 2 2 5 4 7
6 1 2 2 6 5 8
7 1 2 3 7 6 7
8 1 2 3 8 7 8
9 3 2 4 9 1 2 3 4
10 2 2 4 9 2 5 3
$EndElements
"""
FORMAT_4 = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
4
0 1 "support"
1 2 "cables"
1 3 "frame"
2 4 "membrane"
$EndPhysicalNames
$Entities
3 5 1 0
1 -0.5 -0.5 0.25 1 1
2 -0.5 1.5 0.25 1 1
3 3 0.5 0 1 1
4 -0.5 -0.5 0 0 0 0.25 1 2 0
5 -0.5 1 0 0 1.5 0.25 1 2 0
6 2 0.5 0 3 0.5 0 1 2 0
7 -0.5 -0.5 0.25 -0.5 1.5 0.25 1 3 0
8 -0.5 0.5 0 3 1.5 0.25 1 3 0
9 0 0 0 2 1.25 0 1 4 0
$EndEntities
$Nodes
9 8 1 8
0 1 0 1
6
-0.5 -0.5 0.25
0 2 0 1
7
-0.5 1.5 0.25
0 3 0 1
8
3 0.5 0
1 4 0 1
1
0 0 0
1 5 0 1
4
0 1 0
1 6 0 1
5
2 0.5 0
1 7 0 0
1 8 0 0
2 9 0 2
2
3
1 0 0
1 1.25 0
$EndNodes
$Elements
10 10 1 10
0 1 15 1
1 6
0 2 15 1
2 7
0 3 15 1
3 8
1 4 1 1
4 1 6
1 5 1 1
5 4 7
1 6 1 1
6 5 8
1 7 1 1
7 6 7
1 8 1 1
8 7 8
2 9 2 1
10 2 5 3
2 9 3 1
9 1 2 3 4
$EndElements
"""


class Server:
    """A process that reads one mesh after the other; a new one where one died."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None

    def read(self, mesh: Path, arrays: Path, *limits: int) -> None:
        """Do what the worker does for one file."""
        if self._process is None or self._process.poll() is not None:
            self.close()
            self._process = subprocess.Popen(
                [sys.executable, "-c", SERVER, str(Path(reader.__file__).parent)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                text=True,
            )
        self._process.stdin.write(f"{mesh}|{arrays}\n")
        self._process.stdin.flush()
        if self._process.stdout.readline().strip() != "done":
            raise MeshError("Gmsh refuses the file")

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            with suppress(BrokenPipeError):
                self._process.stdin.close()
            self._process.wait()
            self._process.stdout.close()


@pytest.fixture
def server(monkeypatch):
    one = Server()
    monkeypatch.setattr(reader, "_run_worker", one.read)
    yield one
    one.close()


def places(section: str, count: int, version: int) -> range | tuple[int, ...]:
    """Numbers that count in a line of so many: no tags of elements and entities, no boxes around these, no totals."""
    if section in ("MeshFormat", ""):
        return ()
    if section == "PhysicalNames" or count == 1:
        return range(min(count, 2))
    if section == "Nodes":
        return range(count) if version == 2 else range(3) if count == 3 else (3,)
    if section == "Elements":
        return (1, 3, *range(5, count)) if version == 2 else (2, 3) if count == 4 else range(1, count)
    return range(4) if count == 4 else (0, *range(4 if count == 6 else 7, count))


def changed(line: str, section: str, version: int, heads: bool) -> Iterator[str]:
    """The line with one of its numbers changed; of the line that heads a section its first one, in format 4."""
    parts = line.split(" ")
    for place in (0,) if heads and section in ("Nodes", "Elements") else places(section, len(parts), version):
        part = parts[place]
        yield " ".join(
            [*parts[:place], f"{float(part) + 0.375}" if "." in part else f"{int(part) + 1}", *parts[place + 1 :]]
        )


@pytest.mark.parametrize(("text", "version"), [(FORMAT_2, 2), (FORMAT_4, 4)], ids=["format 2", "format 4"])
def test_no_line_is_lost_in_silence(text, version, server, tmp_path, verification_row):
    path, lines = tmp_path / "mesh.msh", text.splitlines()
    whole = fingerprint(path, text)
    assert whole is not None
    silent, tried, section = [], 0, ""
    for number, line in enumerate(lines[:-1]):
        section = line.strip("$").removeprefix("End") if line.startswith("$") else section
        others = () if line.startswith("$") else changed(line, section, version, lines[number - 1].startswith("$"))
        for new in ([], *([one] for one in others)):
            tried += 1
            if fingerprint(path, "\n".join([*lines[:number], *new, *lines[number + 1 :], ""])) == whole:
                silent.append((number, line, new))
    assert silent == []
    verification_row(f"Gmsh mesh of format {version}: silent losses of a line or number", 0, 0, f"{tried} files")
