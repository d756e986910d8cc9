"""The free hub with Exudyn: ``hub_exudyn.py PROBLEM.npz RESULT.npz`` (files: see hub_problem.py).

The beam of `spinup_exudyn`, on a rigid body whose turning is free and driven by a compiled function of time.
"""

from __future__ import annotations

import sys

import exudyn
import numpy as np
from exudyn.advancedUtilities import CreateSymbolicUserFunction
from spinup_exudyn import beam_on_hub, esym, items, measured, tip


def driven_beam(problem):
    """System with the beam on its driven hub, sensors of the tip and of the hub."""
    system, hub, sensor = beam_on_hub(problem, float(problem["inertia"]))
    size, duration = float(problem["torque"]), float(problem["duration"])

    def torque(mbs, t, load):
        return esym.IfThenElse(t < duration, size * (1.0 - esym.cos(2.0 * np.pi / duration * t)), 0.0 * t)

    turning = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=hub, coordinate=2))
    compiled = CreateSymbolicUserFunction(system, torque, "loadUserFunction", itemTypeName="LoadCoordinate")
    system.AddLoad(items.LoadCoordinate(markerNumber=turning, loadUserFunction=compiled))
    angles = system.AddSensor(
        items.SensorNode(nodeNumber=hub, outputVariableType=exudyn.OutputVariableType.Coordinates, storeInternal=True)
    )
    system.Assemble()
    return system, sensor, angles


def run(problem):
    """Record of the tip and of the hub, and what they cost."""
    (record, turned), costs = measured(driven_beam, problem)
    angle = turned[:, 3]
    return {"time": record[:, 0], "angle": angle, **tip(record, angle, float(problem["length"])), **costs}


if __name__ == "__main__":
    np.savez(sys.argv[2], **run(dict(np.load(sys.argv[1]))))
