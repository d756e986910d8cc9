"""A sensor: mean displacement across the film of the nodes on a line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import tautflex as tf


@tf.register
@dataclass(frozen=True)
class EdgeMean(tf.Sensor):
    """Mean displacement along z of the film's nodes at one x [m].

    Parameters
    ----------
    x
        Where they are [m].
    """

    x: float = 0.0

    def prepare(self, state, hub=None):
        model, system = state.model, state.system
        nodes = np.flatnonzero(np.abs(model.nodes[:, 0] - self.x) < 1e-9)
        if not nodes.size:
            raise tf.InputError(f"x: expected a line with nodes, got {self.x:g} m; move it")
        row = np.zeros((1, system.size + 1))
        np.add.at(row[0], system.place[model.translation_dofs[nodes, 2]], 1.0 / nodes.size)
        return tf.PreparedSensor("m", 1, tf.SensorRows(displacement=row[:, :-1]))
