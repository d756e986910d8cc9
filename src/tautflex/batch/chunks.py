"""Runs in chunks that fit the cache of a processor core, every core with chunks of its own."""

from __future__ import annotations

import os
from collections.abc import Callable, Hashable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import jax.numpy as jnp
import numpy as np

from tautflex.batch.equations.equation import EachRun
from tautflex.batch.equations.rate_history import Numbers
from tautflex.batch.library import jax, platform, threadpool_limits
from tautflex.batch.output.response import Response
from tautflex.numeric import Array

Table = dict[str, Array]

# Runs computed side by side unless told otherwise: on a processor what fits the cache of a core, on a GPU what keeps it
# busy; (full, reduced).
_CHUNK = {"cpu": (16, 32)}
_CHUNK_ELSEWHERE = (64, 4096)
# XLA takes half the registers of a processor that has wide ones unless told otherwise.
_OPTIONS: dict[str, dict[str, str | bool]] = {"cpu": {"xla_cpu_prefer_vector_width": "512"}}


def _program(lowered: Any) -> Callable[..., Any]:
    """Machine code, with what only some versions of XLA can be told."""
    try:
        return lowered.compile(compiler_options=_OPTIONS.get(platform()))
    except jax.errors.JaxRuntimeError:
        return lowered.compile()


def usual_chunk(runs: int, reduced: bool) -> int:
    """Runs side by side that suit the device and leave no processor core without work."""
    usual = _CHUNK.get(platform(), _CHUNK_ELSEWHERE)[int(reduced)]
    return min(usual, -(-runs // _workers()))


def _workers() -> int:
    """Threads that compute."""
    if platform() != "cpu":
        return 1
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class ChunkRunner:
    """Compiled runs of one kind after another; ``side_by_side`` tells whether the functions take many at once."""

    def __init__(self, side_by_side: bool) -> None:
        self._side_by_side = side_by_side
        self._compiled: dict[Hashable, Callable[[Numbers], Response]] = {}

    def __call__(
        self,
        function: Callable[[Numbers, EachRun], Response],
        key: Hashable,
        numbers: Table,
        differ: frozenset[str],
        runs: int,
        at_once: int,
    ) -> Response:
        """Record of all runs, the run as first axis, by a function of their numbers that a key tells from others.

        The numbers that ``differ`` have one row per run; the last chunk of runs ``at_once`` is filled up with copies.
        """

        def rows(part: int) -> Table:
            chosen = np.minimum(np.arange(part * at_once, (part + 1) * at_once), runs - 1)
            return {name: value[chosen] if name in differ else value for name, value in numbers.items()}

        whole = key, differ, at_once, platform(), tuple(sorted(numbers))
        if whole not in self._compiled:
            self._compiled[whole] = _program(jax.jit(self.many(function, differ, at_once)).lower(rows(0)))
        compiled = self._compiled[whole]

        def compute(part: int) -> Response:
            return jax.tree.map(np.asarray, compiled(rows(part)))

        # Compiled code lets go of the interpreter. Threads of the linear algebra would only wait for each other.
        with threadpool_limits(1, "blas"), ThreadPoolExecutor(_workers()) as pool:
            return _joined(pool.map(compute, range(-(-runs // at_once))), runs, at_once)

    def many(
        self, function: Callable[[Numbers, EachRun], Response], differ: frozenset[str], at_once: int
    ) -> Callable[[Numbers], Response]:
        """Runs of all rows of the numbers that differ, the run as first axis; not compiled."""
        if self._side_by_side:
            return lambda numbers: jax.tree.map(
                lambda part: jnp.moveaxis(part, -1, 0), function(numbers, EachRun(at_once, differ))
            )
        return EachRun(at_once, differ, 0)(lambda numbers: function(numbers, EachRun()))


def _joined(parts: Iterable[Response], runs: int, at_once: int) -> Response:
    """Records of chunks as one, each put in place as it comes."""
    whole: Any = None
    for number, part in enumerate(parts):
        if whole is None:
            whole = jax.tree.map(lambda leaf: np.empty((runs, *leaf.shape[1:]), leaf.dtype), part)
        first = number * at_once
        for all_runs, leaf in zip(jax.tree.leaves(whole), jax.tree.leaves(part), strict=True):
            all_runs[first : first + at_once] = leaf[: runs - first]
    return whole
