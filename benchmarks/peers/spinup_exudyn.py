"""The spin-up with Exudyn: ``spinup_exudyn.py PROBLEM.npz RESULT.npz`` (files: see spinup_problem.py).

Thin beam elements in absolute coordinates (``ANCFCable2D``), welded to a hub whose angle is prescribed by a compiled
function of time; generalized-alpha method, Newton's method, nothing written to files while it runs.
"""

from __future__ import annotations

import json
import sys
import time
from itertools import pairwise

import exudyn
import exudyn.itemInterface
import numpy as np
from exudyn.advancedUtilities import CreateSymbolicUserFunction
from spinup_problem import median_of_three

esym, items = exudyn.symbolic, exudyn.itemInterface


def hub_angle(problem):
    """Angle of the hub [rad] as a function of time for numbers and for Exudyn's expressions."""
    rate, duration = float(problem["rate"]), float(problem["duration"])
    over = duration / (2.0 * np.pi)

    def angle(t, cos=np.cos, choose=np.where):
        turning = rate / duration * (0.5 * t * t + over * over * (cos(t / over) - 1.0))
        return choose(t < duration, turning, rate * t - 0.5 * rate * duration)

    return angle


def beam_on_hub(problem, inertia=1.0):
    """System with the beam welded to a hub whose centre is held, node of the hub, and a sensor of the tip."""
    system = exudyn.SystemContainer().AddSystem()
    length, elements = float(problem["length"]), int(problem["elements"])
    stations = np.linspace(0.0, length, elements + 1)
    nodes = [system.AddNode(items.NodePoint2DSlope1(referenceCoordinates=[float(x), 0.0, 1.0, 0.0])) for x in stations]
    cables = [
        system.AddObject(
            items.ObjectANCFCable2D(
                length=length / elements,
                massPerLength=float(problem["mass_per_length"]),
                bendingStiffness=float(problem["bending_stiffness"]),
                axialStiffness=float(problem["axial_stiffness"]),
                nodeNumbers=[first, second],
            )
        )
        for first, second in pairwise(nodes)
    ]
    hub_node = system.AddNode(items.NodeRigidBody2D(referenceCoordinates=[0.0, 0.0, 0.0]))
    hub = system.AddObject(items.ObjectRigidBody2D(nodeNumber=hub_node, mass=1.0, inertia=inertia))
    for coordinate in range(2):
        hold(system, hub_node, coordinate)
    system.AddObject(
        items.ObjectJointGeneric(
            markerNumbers=[
                system.AddMarker(items.MarkerBodyRigid(bodyNumber=hub)),
                system.AddMarker(items.MarkerBodyRigid(bodyNumber=cables[0])),
            ],
            constrainedAxes=[1, 1, 0, 0, 0, 1],
        )
    )
    position = exudyn.OutputVariableType.Position
    sensor = system.AddSensor(items.SensorNode(nodeNumber=nodes[-1], outputVariableType=position, storeInternal=True))
    return system, hub_node, sensor


def hold(system, node, coordinate, **drive):
    """Hold a coordinate of a node still, or at a drive."""
    ground = system.AddNode(items.NodePointGround())
    markers = [
        system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=number, coordinate=place))
        for number, place in ((ground, 0), (node, coordinate))
    ]
    system.AddObject(items.ObjectConnectorCoordinate(markerNumbers=markers, **drive))


def spun_beam(problem):
    """System with the beam on a hub of prescribed angle, and a sensor of the tip."""
    system, hub, sensor = beam_on_hub(problem)
    angle = hub_angle(problem)

    def offset(mbs, t, itemNumber, lOffset):
        return angle(t, esym.cos, esym.IfThenElse)

    compiled = CreateSymbolicUserFunction(
        system, offset, "offsetUserFunction", itemTypeName="ObjectConnectorCoordinate"
    )
    hold(system, hub, 2, offsetUserFunction=compiled)
    system.Assemble()
    return system, sensor


def settings(problem):
    """Generalized-alpha with the problem's step and radius, as fast as Exudyn allows."""
    chosen = exudyn.SimulationSettings()
    integration = chosen.timeIntegration
    integration.numberOfSteps = round(float(problem["end"] / problem["step"]))
    integration.endTime = float(problem["end"])
    integration.generalizedAlpha.spectralRadius = float(problem["spectral_radius"])
    integration.generalizedAlpha.computeInitialAccelerations = True
    integration.verboseMode = 0
    # Newton's method took less time here than the modified one. At rest the residual is round-off, which no relative
    # tolerance can ask to fall: below 1e-4 of absolute tolerance Exudyn halves its steps without end.
    integration.newton.useModifiedNewton = False
    integration.newton.relativeTolerance = 1e-6
    integration.newton.absoluteTolerance = 1e-4
    chosen.solution.file.write = False
    chosen.solution.sensors.writePeriod = float(problem["step"])
    dense = int(problem["elements"]) <= 16
    chosen.linearSolver.solverType = exudyn.LinearSolverType.EXUdense if dense else exudyn.LinearSolverType.EigenSparse
    chosen.parallel.numberOfThreads = 1
    return chosen


def measured(build, problem):
    """Records of the sensors of a system that is built anew for every run, and what every result says of it."""
    set_ups, records = [], []

    def timed():
        began = time.process_time()
        system, *sensors = build(problem)
        chosen = settings(problem)
        ready = time.process_time()
        system.SolveDynamic(chosen)
        seconds = time.process_time() - ready
        set_ups.append(ready - began)
        records.append([system.GetSensorStoredData(sensor) for sensor in sensors])
        return seconds

    seconds = median_of_three(timed)
    details = {"version": exudyn.__version__, "element": "ANCFCable2D in absolute coordinates"}
    costs = {"seconds": seconds, "set_up_seconds": set_ups[0], "details": json.dumps(details)}
    return records[0], {name: np.array(value) for name, value in costs.items()}


def tip(record, angle, length):
    """Position of the tip in the hub's axes, less its place at rest: extension and lag [m]."""
    x, y = record[:, 1], record[:, 2]
    return {
        "extension": x * np.cos(angle) + y * np.sin(angle) - length,
        "lag": y * np.cos(angle) - x * np.sin(angle),
    }


def run(problem):
    """Record of the tip and what it cost."""
    (record,), costs = measured(spun_beam, problem)
    angle = hub_angle(problem)(record[:, 0])
    return {"time": record[:, 0], **tip(record, angle, float(problem["length"])), **costs}


if __name__ == "__main__":
    np.savez(sys.argv[2], **run(dict(np.load(sys.argv[1]))))
