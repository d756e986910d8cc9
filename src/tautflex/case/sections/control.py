"""Sections [sensors.NAME] and [controller] of a case file: each sensor's and each law's class is its own section."""

from __future__ import annotations

from tautflex.case.options import Chosen
from tautflex.case.registry import CONTROLLERS, SENSORS


class Sensor(Chosen):
    """What the controller is told."""

    registry = SENSORS


class Controller(Chosen):
    """Law from measurements to commands."""

    registry = CONTROLLERS
