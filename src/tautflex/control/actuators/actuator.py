"""An effect on the structure behind a drive."""

from __future__ import annotations

from dataclasses import dataclass

from tautflex import checks
from tautflex.control.actuators.drive import Drive
from tautflex.mechanics.loads.inputs import Effect
from tautflex.text import brief


@dataclass(frozen=True)
class Actuator(Drive):
    """Effect that a plant commands: a force, a tension, a film that is heated.

    Parameters
    ----------
    effect
        What one unit of it does: `NodalForce`, `EdgeForce`, `TensionGroup`, `StayCable`, `PiezoPair`,
        `MembraneTemperature` or any other, without a signal.

    Examples
    --------
    >>> import tautflex as tf
    >>> tension = tf.Actuator(tf.TensionGroup("x", command="tension"), limit=0.5, lag=0.02)
    >>> tension.limit
    0.5
    """

    effect: Effect
    __repr__ = brief

    def __post_init__(self) -> None:
        super().__post_init__()
        checks.instance("effect", self.effect, Effect, "an effect such as NodalForce(nodes=[8], direction=(0, 0, 1))")
