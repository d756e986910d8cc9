"""Reference that is split into delayed parts whose vibrations cancel, in front of any law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from tautflex.control.law import ControlLaw, LawMatrices, SumOfLaws, law_of, own_memory
from tautflex.control.signals import LoopSpec, Reference
from tautflex.errors import InputError
from tautflex.motion.shaping import checked_modes, sampled_shaper
from tautflex.numeric import Array
from tautflex.text import brief, shown


class ShapedMemory(NamedTuple):
    """Amplitudes, references of the last samples, newest first, shape (taps, 3, axes), and the law's own memory."""

    taps: Array
    past: Array
    law: Any


@dataclass(frozen=True)
class ShapedReference(ControlLaw):
    """Law whose reference is shaped, so that chosen modes stay at rest.

    Parameters
    ----------
    law
        The law that follows the shaped reference; in a case the table controller.law, with the keys of a controller.
    shaper
        ``"ZV"`` or ``"ZVD"``, which also forgives modes that are not quite where they were thought.
    frequencies
        Natural frequencies of the modes [Hz], those of the loop that follows, any number.
    damping_ratios
        Their damping ratios, in [0, 1), one for all or one each.

    Raises
    ------
    InputError
        If a number is out of range, or the law follows no reference; when a loop starts, if it has no free hub.

    Examples
    --------
    >>> import tautflex as tf
    >>> lqg = tf.LQG(tolerances={"attitude": 1e-2}, efforts={"torque": 0.1})
    >>> tf.ShapedReference(lqg, "ZVD", [4.43]).shaper
    'ZVD'
    """

    law: ControlLaw
    shaper: str
    frequencies: Sequence[float]
    damping_ratios: Sequence[float] = (0.0,)
    __repr__ = brief

    def __post_init__(self) -> None:
        object.__setattr__(self, "law", law_of("law", self.law))
        parts = self.law.laws if isinstance(self.law, SumOfLaws) else (self.law,)
        if not any(part.follows_reference for part in parts):
            raise InputError(
                f"law: expected one that follows the reference of the hub, got {shown(self.law)}, which does not; add "
                "it to the shaped law instead"
            )
        checked_modes(self.shaper, self.frequencies, self.damping_ratios)

    def _taps(self, spec: LoopSpec) -> Array:
        return sampled_shaper(self.shaper, self.frequencies, self.damping_ratios, spec.interval)

    def start(self, spec: LoopSpec) -> ShapedMemory:
        """No reference before the first."""
        if not spec.axes:
            raise InputError(
                "shaper: expected a free hub, which follows a reference, got one whose motion is prescribed; give the "
                "plant a FreeHub, or the maneuver a profile that is shaped"
            )
        taps = self._taps(spec)
        try:
            own = self.law.start(spec)
        except InputError as error:
            # That there is no model yet is the loop's to mend, see `start_law`.
            raise error if str(error).startswith("model:") else InputError(f"law.{error}") from None
        return ShapedMemory(taps, np.zeros((len(taps), 3, spec.axes)), own)

    def act(self, memory: ShapedMemory, measurement: Array, reference: Reference) -> tuple[ShapedMemory, Array]:
        """The law's command for the sum of delayed references."""
        memory = own_memory(memory, ShapedMemory)
        past = np.concatenate([np.array(reference[1:4])[None], memory.past[:-1]])
        shaped = np.tensordot(memory.taps, past, 1)
        own, command = self.law.act(
            memory.law, measurement, Reference(reference.time, shaped[0], shaped[1], shaped[2], reference.goal)
        )
        return ShapedMemory(memory.taps, past, own), command

    def matrices(self, spec: LoopSpec) -> LawMatrices | None:
        """A shift register in front of the law's."""
        law = self.law.matrices(spec)
        return None if law is None else in_series(self._taps(spec), law, spec.axes)


def in_series(taps: Array, law: LawMatrices, axes: int) -> LawMatrices:
    """Law behind a sum of delayed references; its state comes first, then references, newest first."""
    wide, count, n = 3 * axes, len(taps) - 1, len(law.A)
    seen = law.D.shape[1] - wide
    # The law's z is ``keep z + late``, with late from the register.
    keep = np.diag(np.concatenate([np.ones(seen), np.full(wide, taps[0])]))
    late = np.concatenate([np.zeros((seen, count * wide)), np.kron(taps[1:], np.eye(wide))])
    shift = np.kron(np.eye(count, k=-1), np.eye(wide))
    first = np.zeros((count * wide, seen + wide))
    first[:wide, seen:] = np.eye(wide)[: min(wide, count * wide)]
    return LawMatrices(
        np.block([[law.A, law.B @ late], [np.zeros((count * wide, n)), shift]]),
        np.concatenate([law.B @ keep, first]),
        np.concatenate([law.C, law.D @ late], axis=1),
        law.D @ keep,
        np.concatenate([law.b, np.zeros(count * wide)]),
        law.d,
    )
