"""The registered tasks on a coarse mesh and for a short time."""

from __future__ import annotations

from typing import Any

from tautflex.case import Case
from tautflex.learning.cases import task_case


def coarse(name: str, duration: float = 0.3, **sections: Any) -> Case:
    """Case of a task with 10 x 5 cells: twice the spacing, tension and area of its cables, so the same film."""
    cables = {"per_long_edge": 11, "per_short_edge": 6, "area": 3.14e-6, "pretension_x": 0.117882, "pretension_y": 0.22}
    own = {"mesh": {"divisions": (10, 5)}, "cables": cables, "task": {"duration": duration}}
    return task_case(name).replaced(**{**own, **sections})
