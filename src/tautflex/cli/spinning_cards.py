"""What a person sees of spinning modes, the Campbell table and participation."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from tautflex.cli.cards import half_waves, say, show_modes


def show_modes_and_spin(case: Path, answer: Mapping[str, Any]) -> None:
    """Print what was asked for beside the modes at rest, then these."""
    at_rest = answer["prestress"]["min_principal_resultant"]
    if "spinning" in answer:
        one = answer["spinning"]
        Console().print(_modes_table(one))
        _warn([one["rate"]], [one["stable"]], [one["min_principal_resultant"]], at_rest)
    if "campbell" in answer:
        many = answer["campbell"]
        console = Console()
        for table in _campbell_tables(many, console.width):
            console.print(table)
        _warn(many["rates"], many["stable"], many["min_principal_resultant"], at_rest)
    if "participation" in answer:
        parts = ", ".join(
            "-" if math.isnan(part) else f"{part:.3f}" for part in answer["participation"]["completeness"]
        )
        say(f"These modes hold of the free mass (x, y, z, rx, ry, rz): {parts}")
    show_modes(case, answer)


def _warn(rates: list[float], stable: list[bool], resultants: list[float], at_rest: float) -> None:
    """Say where motions grow and where the film is compressed by more than a wrinkled one is."""
    unstable = [f"{rate:.4g}" for rate, holds in zip(rates, stable, strict=True) if not holds]
    pressed = [f"{rate:.4g}" for rate, value in zip(rates, resultants, strict=True) if value < -1e-3 * abs(at_rest)]
    if unstable:
        say(f"warning: unstable at {', '.join(unstable)} rad/s, some motion grows")
    if pressed:
        text = f"warning: compressed film at {', '.join(pressed)} rad/s, smallest principal resultant"
        say(f"{text} {min(resultants):.3g} N/m; membrane.law = 'tension-field' lets it wrinkle instead")


def _modes_table(one: Mapping[str, Any]) -> Table:
    axis = ", ".join(f"{part:g}" for part in one["axis"])
    table = Table(title=f"spinning at {one['rate']:g} rad/s about ({axis})", title_style="bold")
    for name in ("mode", "frequency [Hz]", "damping ratio", "whirl", "half waves (m,n)"):
        table.add_column(name, justify="right")
    columns = one["frequencies"], one["damping_ratios"], one["whirl"], one["labels"]
    for number, (frequency, ratio, whirl, label) in enumerate(zip(*columns, strict=True), start=1):
        sense = "forward" if whirl > 0.1 else "backward" if whirl < -0.1 else "-"
        table.add_row(f"{number}", f"{frequency:.4f}", f"{ratio:.2e}", sense, half_waves(label))
    return table


def _campbell_tables(many: Mapping[str, Any], width: int) -> list[Table]:
    """As many branches side by side as the terminal has room for."""
    rows = [
        [
            "grows" if growth > 0.0 and frequency == 0.0 else f"{frequency:.3f}"
            for frequency, growth in zip(*row, strict=True)
        ]
        for row in zip(many["frequencies"], many["growth_rates"], strict=True)
    ]
    rates = [f"{rate:.4g}" for rate in many["rates"]]
    cell = max(len(text) for row in rows for text in row) + 2
    room = max(1, (width - 2 - max(5, *map(len, rates))) // cell)
    axis = ", ".join(f"{part:g}" for part in many["axis"])
    tables = []
    for first in range(0, len(rows[0]), room):
        names = [f"{branch + 1}" for branch in range(first, min(first + room, len(rows[0])))]
        title = f"frequencies [Hz] of branches {names[0]} to {names[-1]}, spinning about ({axis})"
        table = Table(title=title, title_style="bold", box=None, padding=(0, 1))
        for name in ("rad/s", *names):
            table.add_column(name, justify="right", no_wrap=True)
        for rate, row in zip(rates, rows, strict=True):
            table.add_row(rate, *row[first : first + room])
        tables.append(table)
    return tables
