"""Doors of the control room, for the tests of wrong objects: name -> (callable, right keywords)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import tautflex as tf
from verification.linear_plants import modal_plant, spec_of


def control_doors(t):
    state = t["state"]
    push = {"push": tf.NodalForce([0], (0.0, 0.0, 0.0)).prepare(state.system)}
    view = {"inputs": push, "motion": tf.Stop(0.1, 0.1).start(), "values": {"push": 0.0}, "modes": 3}
    hub = spec_of(
        modal_plant([1.3, 2.1], [0.002, 0.004], [[0.4], [0.3]], [[0.8, 0.6]], axes=1, inertia=5.0), 0.01, noise=1e-4
    )
    held = spec_of(
        modal_plant(
            [1.3, 2.1], [0.01] * 2, np.eye(2), np.eye(2), velocities=True, bilinear=[np.eye(2), np.eye(2)]
        ),
        0.01,
        noise=1e-4,
    )  # fmt: skip
    pairs = replace(
        held,
        measurements=(tf.Channel("w", "m", 2), tf.Channel("dw", "m/s", 2)),
        model=replace(held.model, outputs=("w[0]", "w[1]", "dw[0]", "dw[1]")),
    )

    def started(law, spec):
        return lambda **given: law(**given).start(spec)

    def bound(sensor, on=state):
        return lambda **given: sensor(**given).prepare(on)

    reading = {"noise": 1e-6, "bias": 0.0, "delay": 0.0, "resolution": 0.0}
    cost = {"tolerances": {"attitude": 1e-3}, "efforts": {"torque": 1.0}, "modes": 1, "feedforward": True}
    filtered = cost | {"coordinate_noise": 1e-4, "hub_noise": 1e-4, "measurement_noise": {"attitude": 1e-5}}
    tension = {
        "commands": ("u0",), "limit": 1.0, "modes": 2, "floor": 0.0, "coordinate_noise": 1e-4, "hub_noise": 1e-4,
        "measurement_noise": {"y0": 1e-5},
    }  # fmt: skip
    shaped = {"shaper": "ZVD", "frequencies": (1.0,), "damping_ratios": (0.0,)}
    turn = {
        "stiffness": 1.0,
        "damping": 1.0,
        "inertia": 0.0,
        "attitude": "attitude",
        "rate": "rate",
        "torque": "torque",
    }
    drive = {"limit": 1.0, "rate": 10.0, "lag": 0.0, "delay": 0.0, "resolution": 0.0, "monitor": False}
    push_film = tf.NodalForce([int(np.argmax(state.model.nodes[:, 0] == 0.0))], direction=(0, 0, 1))
    spacecraft = tf.FreeHub(20.0, (3.0, 4.0, 5.0))
    wheel = tf.Plant(state, spacecraft, {"torque": tf.HubTorque("x")}, {"rate": tf.Rate()}, interval=2e-3)
    points = {"points": (0.2, 0.1), "component": "w"}
    return {
        "authority": (tf.authority, {"plant": state, "limits": {"push": 1.0}, **view}),
        "linearize": (
            tf.linearize,
            {"plant": state, "sensors": {"A": tf.Displacement((0.2, 0.1))}, "hub": None, "damping": None,
             "coupling": None, **view},
        ),
        "FunctionLaw": (started(tf.FunctionLaw, held), {"function": lambda time, y: 0.0}),
        "PD": (started(tf.PD, hub), turn | shaped),
        "LQR": (tf.LQR, cost),
        "LQG": (started(tf.LQG, hub), filtered),
        "MPC": (tf.MPC, filtered | {"limits": {"torque": 1.0}, "horizon": 5}),
        "PositivePositionFeedback": (
            started(tf.PositivePositionFeedback, held),
            {"gain": 0.1, "frequency": 1.0, "measurement": "y0", "command": "u0", "damping_ratio": 0.5},
        ),
        "IndependentModalControl": (
            started(tf.IndependentModalControl, pairs),
            {"displacement": "w", "velocity": "dw", "modes": 2, "effort": 1.0},
        ),
        "TensionDamping": (started(tf.TensionDamping, held), tension | {"gain": 1.0}),
        "StiffnessSwitching": (started(tf.StiffnessSwitching, held), tension | {"mode": 1}),
        "ShapedReference": (started(tf.ShapedReference, hub), {"law": tf.PD(1.0, 1.0), **shaped}),
        "HubTorque": (tf.HubTorque, drive | {"axis": "x", "momentum": 1.0}),
        "Actuator": (tf.Actuator, drive | {"effect": push_film}),
        "Plant": (
            tf.Plant,
            {"state": state, "hub": spacecraft, "actuators": {"torque": tf.HubTorque("x")},
             "sensors": {"rate": tf.Rate()}, "interval": 2e-3, "time_step": 1e-3, "method": None, "damping": None,
             "maneuver": None, "inputs": [], "probes": {"A": (0.2, 0.1)}},
        ),
        "close_loop": (
            tf.close_loop,
            {"plant": wheel, "law": lambda time, y: -0.1 * y[:1], "maneuver": None, "end_time": 4e-3, "seed": 0,
             "frames": 2},
        ),
        "Attitude": (bound(tf.Attitude), reading),
        "Rate": (bound(tf.Rate), reading),
        "Displacement": (bound(tf.Displacement), reading | points),
        "Velocity": (bound(tf.Velocity), reading | points),
        "CableTensionSensor": (bound(tf.CableTensionSensor, t["hung"]), reading | {"cables": [0]}),
        "SurfaceRms": (bound(tf.SurfaceRms), reading),
        "ModalCoordinates": (bound(tf.ModalCoordinates), reading | {"modes": 2}),
    }  # fmt: skip
