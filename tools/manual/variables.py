"""Tables of all stored variables, from the tables that results are written from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from manual.pages import write
from tautflex.solvers import variables

TABLES = {
    "A run": variables.RUN,
    "A run on a free hub, beside these": {k: v for k, v in variables.HUB.items() if variables.RUN.get(k) != v},
    "A run of a reduced model, beside these": {
        k: v for k, v in variables.REDUCED_RUN.items() if variables.RUN.get(k) != v
    },
    "A closed loop, beside these": variables.LOOP,
    "The mesh, in all of them": variables.MESH,
    "A batch": variables.BATCH,
    "Modes": variables.MODES,
    "Spinning modes": variables.SPINNING_MODES,
    "A Campbell table": variables.CAMPBELL,
    "Data for attitude control": variables.APPENDAGE,
    "Authority": variables.AUTHORITY,
    "The surface": variables.SURFACE,
    "Proper orthogonal modes": variables.POD,
    "Ranked modal assurance": variables.MAC,
    "A spectrum": variables.SPECTRUM,
    "A scalogram": variables.SCALOGRAM,
}


def text() -> str:
    """All tables, a heading each."""
    lines = []
    for title, table in TABLES.items():
        lines += [f"## {title}", "", "| variable | dimensions | unit | meaning |", "|---|---|---|---|"]
        for name, (dims, units, words) in table.items():
            unit, meaning = (part.format(units="unit", name="the record") for part in (units, words))
            lines.append(f"| `{name}` | {', '.join(dims)} | {'' if unit == '1' else unit} | {meaning} |")
        lines.append("")
    return "\n".join(lines)


def setup(app: Any) -> dict[str, bool]:
    """Sphinx calls this."""
    app.connect("builder-inited", lambda app: write(Path(app.srcdir) / "generated" / "variables.md", text()))
    return {"parallel_read_safe": True}
