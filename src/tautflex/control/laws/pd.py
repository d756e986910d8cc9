"""Attitude control as every spacecraft has it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tautflex import checks
from tautflex.control.law import LawMatrices, LinearLaw
from tautflex.control.laws.shaped_reference import in_series
from tautflex.control.signals import LoopSpec
from tautflex.errors import InputError
from tautflex.motion.shaping import SHAPERS, checked_modes, sampled_shaper
from tautflex.numeric import Indices
from tautflex.text import brief


@dataclass(frozen=True)
class PD(LinearLaw):
    """Torque in proportion to the errors of attitude and rate.

    ``T = k (theta_r - theta) + d (omega_r - omega) + J alpha_r``, about every axis of the hub.

    Parameters
    ----------
    stiffness
        Torque per angle, k [N m/rad], >= 0.
    damping
        Torque per rate, d [N m s/rad], >= 0.
    inertia
        Torque per angular acceleration of the reference, J [kg m^2], >= 0; 0 is no feedforward.
    shaper
        ``"none"``, ``"ZV"`` or ``"ZVD"``: the reference is split so that the modes with ``frequencies`` stay at rest.
    frequencies
        Natural frequencies of these modes [Hz], one or more.
    damping_ratios
        Their damping ratios, in [0, 1), one for all or one each.
    attitude, rate, torque
        Names of the sensors of attitude and rate, and of the actuator, or of one axis of each, as ``"rate[0]"``. About
        three axes angles are rotation vectors: their difference is the error as long as it is small.

    Raises
    ------
    InputError
        If a number is out of range, or frequencies and shaper contradict each other.

    Examples
    --------
    >>> import tautflex as tf
    >>> law = tf.PD(stiffness=30.0, damping=22.0, inertia=7.46, shaper="ZVD", frequencies=[4.54])
    >>> law.shaper
    'ZVD'
    """

    stiffness: float
    damping: float
    inertia: float = 0.0
    shaper: str = "none"
    frequencies: Sequence[float] = ()
    damping_ratios: Sequence[float] = (0.0,)
    attitude: str = "attitude"
    rate: str = "rate"
    torque: str = "torque"
    __repr__ = brief

    def __post_init__(self) -> None:
        for name in ("attitude", "rate", "torque"):
            checks.instance(name, getattr(self, name), str, "a name, such as 'rate' or 'rate[0]'")
        for name in ("stiffness", "damping", "inertia"):
            checks.non_negative(name, getattr(self, name))
        frequencies = checks.float_array("frequencies", self.frequencies, (None,))
        checks.float_array("damping_ratios", self.damping_ratios, (None,))
        if checks.one_of("shaper", self.shaper, ("none", *SHAPERS)) != "none":
            checked_modes(self.shaper, self.frequencies, self.damping_ratios)
        elif frequencies.size:
            raise InputError(
                f"frequencies: expected none with shaper = 'none', got {frequencies.tolist()}; set shaper = 'ZVD'"
            )

    def matrices(self, spec: LoopSpec) -> LawMatrices:
        """Gains, behind the shaper."""
        axes, seen = spec.axes, len(spec.measured)
        whole, rate, torque = checks.together(
            lambda: self._whole_attitude(spec),
            lambda: spec.measurement("rate", self.rate, "rad/s"),
            lambda: spec.command("torque", self.torque, "N m"),
        )
        places = spec.measurement("attitude", self.attitude, "rad"), rate
        each = places[0] - whole[0]
        for name, found in (("rate", places[1]), ("torque", torque)):
            if len(found) != len(each):
                raise InputError(
                    f"{name}: expected {len(each)}, as many numbers as of attitude {self.attitude!r}, got {len(found)} "
                    f"of {getattr(self, name)!r}; name one axis of each, such as 'attitude[0]' and 'rate[0]', or all"
                )
        gain = np.zeros((len(spec.commanded), seen + 3 * axes))
        for number, (value, place) in enumerate(zip((self.stiffness, self.damping), places, strict=True)):
            gain[torque, place] = -value
            gain[torque, seen + number * axes + each] = value
        gain[torque, seen + 2 * axes + each] = self.inertia
        law = LawMatrices.static(gain)
        if self.shaper == "none":
            return law
        return in_series(sampled_shaper(self.shaper, self.frequencies, self.damping_ratios, spec.interval), law, axes)

    def _whole_attitude(self, spec: LoopSpec) -> Indices:
        """Places of the attitude about all axes."""
        whole = spec.measurement("attitude", self.attitude.partition("[")[0])
        if not len(whole) == spec.axes > 0:
            raise InputError(
                f"attitude: expected one number for each of the {spec.axes} axes of the hub, got {len(whole)} of "
                f"{self.attitude!r}; PD turns a free hub: give the plant one, and an Attitude()"
            )
        return whole
