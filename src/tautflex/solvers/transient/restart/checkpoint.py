"""Restartable state of a run: its motion, and everything else that the next step depends on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from tautflex.errors import InputError
from tautflex.numeric import Array
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.text import card

_NONE = np.zeros(0)
# Numbers of one structure that was built twice agree to this part.
_SAME = 1e-9


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """State from which a run goes on: `Run.final`, given to ``simulate(..., initial=...)``.

    Parameters
    ----------
    time
        [s].
    displacement, velocity
        Free unknowns of the structure [m, rad] and their velocities, shape (size,).
    hub
        Attitude, position, twist, momentum, wrench and accelerations of a free hub, shape (31,); (0,): there was none.
    structure
        Numbers by which a structure is recognised: name -> sum with weights, and norm.
    question
        What the memory belongs to, in words by name: plant, method, steps, hub.
    memory
        What steps leave for the next one, by name; empty where a run ended inside a step.
    """

    time: float
    displacement: Array
    velocity: Array
    hub: Array = field(default_factory=lambda: _NONE)
    structure: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    question: Mapping[str, str] = field(default_factory=dict)
    memory: Mapping[str, Array] = field(default_factory=dict)

    def __repr__(self) -> str:
        size = sum(np.asarray(each).nbytes for each in (self.displacement, self.velocity, *self.memory.values()))
        lines = {
            "time": f"{self.time:.6g} s",
            "structure": f"{len(self.displacement)} unknowns{', on a free hub' if len(self.hub) else ''}",
            "goes on": "as if never cut, with the same" if self.memory else "from its motion alone",
            **(self.question if self.memory else {}),
            "memory": f"{size / 1e6:.3g} MB",
        }
        return card(self, lines)

    def check(self, state: PrestressedState) -> None:
        """Raise InputError, which names what differs, unless this is a state of the same structure."""
        here = structure_of(state)
        size = state.system.size
        if len(self.displacement) != size:
            raise InputError(
                f"initial: expected a state of this structure, of {size} unknowns, got one of "
                f"{len(self.displacement)}; simulate it from its start, or give the structure that it belongs to"
            )
        others = [
            name
            for name, numbers in self.structure.items()
            if not np.allclose(numbers, here[name], rtol=_SAME, atol=_SAME * abs(here[name][1]))
        ]
        if others:
            raise InputError(
                f"initial: expected a state of this structure, got one whose {' and '.join(others)} differ; simulate "
                "it from its start, or give the structure that it belongs to"
            )

    def remembers(self, question: Mapping[str, str]) -> bool:
        """Whether the memory serves a run of this question; else it starts from the motion alone."""
        return bool(self.memory) and dict(self.question) == dict(question)


def structure_of(state: PrestressedState) -> dict[str, tuple[float, ...]]:
    """Numbers by which a structure is recognised."""
    system = state.system
    corners = [group.connectivity.ravel() for group in system.model.groups]
    parts = {
        "node positions": system.model.nodes,
        "elements": np.concatenate(corners) if corners else _NONE,
        "supports": system.model.free_dofs,
        "masses": system.inertia.mass_entries,
        "stiffness and prestress": state.tangent_entries,
        "dampers": np.concatenate([damper.values for damper in system.model.dampers] or [_NONE]),
    }
    return {name: fingerprint(np.asarray(values, dtype=float)) for name, values in parts.items()}


@lru_cache(maxsize=8)
def _weights(count: int) -> Array:
    return np.cos(np.arange(1.0, count + 1.0))


def fingerprint(values: Array) -> tuple[float, float]:
    """Sum with weights that tell places apart, over the root of their number, and norm."""
    flat = values.ravel()
    # One thread: more of them would wait for each other longer than these sums take.
    whole, square = np.einsum("i,i->", _weights(flat.size), flat), np.einsum("i,i->", flat, flat)
    return float(whole) / max(flat.size, 1) ** 0.5, float(np.sqrt(square))
