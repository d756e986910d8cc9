"""Write which functions the commands `check`, `run` and `report` call of a case of the template m2, for which types.

``python tools/compiled.py`` rewrites ``src/tautflex/data/compiled.jsonl``, by which other processes compile beside a
first command (`tautflex.compilers`); with ``--check`` it says what is missing there or too much, and writes nothing.
A line is the number of the first command that needs a function, its module, its name and the types of its arguments:
those with most machine code come first.
"""

from __future__ import annotations

import gc
import json
import os
import sys
import tempfile
from contextlib import redirect_stdout

from tautflex import compilers
from tautflex.cli import main

SMALL = "mesh.divisions=[2,2]", "cables.per_long_edge=3", "cables.per_short_edge=3", "solver.end_time=1.9"
COMMANDS = (
    ("check", "m2.toml", *(word for one in SMALL for word in ("--set", one))),
    ("run", "m2.toml", *(word for one in SMALL for word in ("--set", one))),
    ("report", "m2"),
)


def called() -> dict[tuple[str, ...], int]:
    """Functions that Python has called in this process as the list has them, and the size of their machine code."""
    from tautflex.linking import Kernel

    return {
        (
            kernel.__module__,
            kernel.__qualname__,
            json.dumps([compilers.written(each) for each in types]),
        ): kernel._cache.size(types, kernel.targetctx)
        for kernel in gc.get_objects()
        if isinstance(kernel, Kernel)
        for types in kernel.overloads
    }


def lines() -> list[str]:
    """Lines of the list, from commands that are run in a folder of their own."""
    os.environ[compilers.SWITCH], place = "0", os.getcwd()
    found: dict[tuple[str, ...], str] = {}
    with tempfile.TemporaryDirectory() as folder, redirect_stdout(sys.stderr):
        os.chdir(folder)
        try:
            main(["init", "m2.toml"])
            for number, command in enumerate(COMMANDS):
                if main(command) != 0:
                    raise SystemExit(f"{command[0]}: expected exit code 0")
                new = {key: size for key, size in called().items() if key not in found}
                for key in sorted(new, key=lambda key: (-new[key], key)):
                    found[key] = json.dumps([number, *key[:2], json.loads(key[2])], separators=(",", ":"))
        finally:
            os.chdir(place)
    return list(found.values())


if __name__ == "__main__":
    now, before = lines(), compilers.LIST.read_text(encoding="utf-8").splitlines() if compilers.LIST.exists() else []
    for line in sorted(set(now) ^ set(before)):
        print("+" if line in now else "-", line[:200])
    if "--check" in sys.argv[1:]:
        raise SystemExit(set(now) != set(before))
    compilers.LIST.write_text("\n".join([*now, ""]), encoding="utf-8")
