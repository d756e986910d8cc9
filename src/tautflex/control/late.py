"""What drives and sensors add to a linear view: lags and delays; what of them is not linear is told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tautflex.control.actuators.drive import Drive
from tautflex.control.linear import LinearPlant
from tautflex.control.sampled import Lateness
from tautflex.control.sensors.sensor import Sensor
from tautflex.control.signals import Channel

# Numbers of drives that a linear view has no place for.
_LEFT_OUT = ("limit", "rate", "resolution", "momentum")


def behind_drives(
    view: LinearPlant,
    drives: Mapping[str, Drive],
    inputs: Sequence[Channel],
    sensors: Mapping[str, Sensor],
    outputs: Sequence[Channel],
) -> LinearPlant:
    """Linear view behind its drives and in front of its sensors, whose channels are given."""
    lag, delay, remarks = list[float](), list[float](), dict(view.remarks)
    for channel in inputs:
        drive = drives[channel.name]
        lag += [drive.lag] * channel.size
        delay += [drive.delay] * channel.size
        left = [name for name in _LEFT_OUT if np.any(getattr(drive, name, None) or 0.0)]
        if left:
            told = f"without the {' and '.join(left)} of its drive"
            remarks |= {label: "; ".join(filter(None, (remarks.get(label), told))) for label in channel.labels}
    age = [sensors[channel.name].delay for channel in outputs for _ in range(channel.size)]
    late = Lateness(tuple(lag), tuple(delay), tuple(age))
    return replace(view, late=late if late else None, remarks=remarks)
