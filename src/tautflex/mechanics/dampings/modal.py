"""Damping mode by mode."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.dampings.damping import Damping, LinearStructure
from tautflex.mechanics.dampings.matrix import DampingMatrix
from tautflex.text import brief

# Modes that share one ratio where nothing is said.
_MODES = 10


@dataclass(frozen=True)
class Modal(Damping):
    """Given ratios of the lowest natural modes, ``C = sum_k 2 zeta_k w_k (M phi_k)(M phi_k)'``.

    Parameters
    ----------
    ratio
        Ratio of critical damping of the lowest modes [-], in [0, 1]: one number, or one per mode.
    modes
        Number of the lowest modes that share one ratio, by default 10; not beside a number per mode.

    Notes
    -----
    Modes are those of the prestressed reference at rest, in the order of `tautflex.solve_modes`, mass-normalised: so
    ``phi_j' C phi_k = 2 zeta_k w_k`` for j = k and 0 for others [Clough & Penzien, Dynamics of Structures, 12-3]. Modes
    above the listed ones, rigid motions and unstable modes are not damped.

    Examples
    --------
    >>> import tautflex as tf
    >>> tf.Modal(ratio=0.01, modes=20).modes
    20
    """

    ratio: float | tuple[float, ...]
    modes: int | None = None
    __repr__ = brief

    def __post_init__(self) -> None:
        if checks.numbers("ratio", self.ratio).ndim:
            given = checks.float_array("ratio", self.ratio, (None,)).tolist()
            object.__setattr__(self, "ratio", tuple(checks.between("ratio", each, 0.0, 1.0) for each in given))
            if not given:
                raise InputError("ratio: expected at least one ratio, got none; leave the damping out for none")
            if self.modes is not None:
                raise InputError(
                    f"modes: expected none beside a ratio per mode, got {self.modes!r}; give one ratio for all of them"
                )
        else:
            checks.between("ratio", self.ratio, 0.0, 1.0, remedy="0.01 is usual for films")
            if self.modes is not None:
                checks.whole("modes", self.modes, 1)

    def matrix(self, structure: LinearStructure) -> DampingMatrix:
        """``2 zeta_k w_k`` and ``M phi_k`` of the modes."""
        # A number per mode, or one for all; plain arithmetic either way.
        ratio: Any = self.ratio
        count = len(ratio) if np.ndim(ratio) > 0 else self.modes or min(_MODES, structure.system.size)
        frequencies, shapes = structure.modes(count)
        return DampingMatrix(
            vectors=np.ascontiguousarray((structure.mass_matrix @ shapes.T).T),
            coefficients=ratio * (2.0 * frequencies),
        )
