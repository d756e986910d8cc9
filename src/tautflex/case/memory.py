"""Estimate of what a case needs in memory, and what the machine has, before anything is allocated.

Own, because psutil knows the system's figure but not the limit of a container.
"""

from __future__ import annotations

import os
from pathlib import Path

# Measured on factorized antennas: stiffness, mass, inertia blocks and the LDL' factor, per triangle.
BYTES_PER_TRIANGLE = 20_000
BYTES_PER_STORED_NUMBER = 8
_FALLBACK = 16_000_000_000


def mesh_bytes(divisions: tuple[int, int]) -> int:
    """Bytes [B] of model, matrices and factor of a film of ``divisions`` cells."""
    return 2 * divisions[0] * divisions[1] * BYTES_PER_TRIANGLE


def history_bytes(stored_steps: float, probe_count: int, divisions: tuple[int, int], all_fields: bool) -> float:
    """Bytes [B] of the stored history: six numbers a probe, ten a step, three a node if fields are kept."""
    per_step = 10 + 6 * probe_count
    if all_fields:
        per_step += 3 * (divisions[0] + 1) * (divisions[1] + 1)
    return stored_steps * per_step * BYTES_PER_STORED_NUMBER


def available_bytes() -> int:
    """Memory [B] that can be had now: the system's figure, or the container's limit if that is lower."""
    return min(_system_bytes(), _container_bytes())


def _system_bytes() -> int:
    try:
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    except (OSError, ValueError):
        pass
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return _FALLBACK


def _container_bytes() -> int:
    try:
        return int(Path("/sys/fs/cgroup/memory.max").read_text(encoding="ascii"))
    except (OSError, ValueError):
        return 2**63
