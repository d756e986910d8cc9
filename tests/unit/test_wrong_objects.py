"""Every public function and class meets wrong objects at each of its parameters: only the package's errors come out."""

from __future__ import annotations

import inspect
import itertools
import math

import numpy as np
import pytest
import xarray as xr

import tautflex as tf
from tautflex import plot
from tautflex.case import parse_case
from unit.control_doors import control_doors
from verification.builders import FILM_CASE

# Made by the package, or written by authors of elements, laws, methods and maneuvers; not doors that users go through.
INNER = """
Basis BasisVectors Batch Case Channel Checkpoint Combination ControlLaw Damping DampingMatrix Effect Element
ElementBlock ElementGroup FixedAxis FollowerForce HubState HyperReducedModel InertiaPoints Law LawFunction LawMatrices
LinearInput LinearLaw LinearPlant LinearStructure LoopSpec Maneuver Method OneStageMethod PatternLoad PlantState
PreparedInput PreparedSensor RateFormula ReducedModel ReeledCables Reference RigidMotion Run Segment SensedMotion Sensor
SensorRows Shape Stage StepScheme StressChange Stretch TensionOnly TimeInput UnitStep isoparametric_membrane register
CompiledPlant FunctionalTwin HoldTask Link MeshSection Policy PolicyLaw Scenario SlewTask StopTask Study Task Trained
Tuned
evaluate train tune_law
"""
STUDY = """base = "film.toml"
[axes]
"damping.beta" = [0.0, 1e-3]
[design]
minimize = ["surface.rms"]
trials = 1
[design.variables]
"damping.beta" = { from = 0.0, to = 1e-3 }
"""
LOOP = {
    "actuators": {"push": {"kind": "nodal-force", "near": (0.2, 0.2), "direction": (0, 0, 1)}},
    "sensors": {"film": {"kind": "displacement", "points": (0.2, 0.2)}},
    "controller": {"kind": "positive-position-feedback", "gain": 1.0, "frequency": 9.0, "measurement": "film",
                   "command": "push"},
}  # fmt: skip
ANY = {
    ("MeshData", "groups"),
    ("MeshData", "beam_orientation"),
    ("read_mesh", "names"),
}  # parameters of which nothing is asked before they are used


class Wrong:
    """An object of no use to anyone."""

    def __repr__(self):
        return "Wrong()"


@pytest.fixture(scope="module")
def things(tmp_path_factory):
    """Right arguments, by kind."""
    case = parse_case(FILM_CASE)
    folder = tmp_path_factory.mktemp("doors")
    model = tf.build_model(case)
    state = tf.solve_prestress(model)
    options = {"time_step": 0.01, "end_time": 0.3, "probes": {"A": (0.2, 0.1)}, "fields": "all"}
    run = tf.simulate(state, initial_velocity=lambda x, y: 0.01 + 0 * x, **options)
    tf.save(run.data, folder / "run.nc")
    (folder / "film.toml").write_text(FILM_CASE, encoding="utf-8")
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    material = tf.Material(3e9, 1500.0, 0.3)
    film, rope = tf.MembraneSection(material, 1e-4), tf.CableSection(material, 1e-6)
    mesh = {
        "nodes": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 0], [2, 0, 0], [2, 1, 0], [3, 1, 0]],
        "triangles": [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]], "quads": None, "surfaces": None,
        "membrane": film, "membrane_stress": (1e4, 1e4, 0.0), "membrane_orientation": (1, 0, 0),
        "cables": [[1, 5], [2, 6]], "cable": rope, "cable_tension": 1.0,
        "beams": [[6, 7]], "beam": tf.BeamSection(material, 1e-4, 1e-9, 1e-9, 2e-9), "beam_axial_force": 0.0,
        "beam_orientation": (0, 0, 1), "prestress_mode": "uniform",
        "supports": [tf.Support.clamped((0, 1, 2, 3, 5, 6))], "masses": [tf.PointMass(7, 0.1)],
        "links": [], "springs": [], "dampers": [], "selections": {},
    }  # fmt: skip
    hung = tf.solve_prestress(tf.Model.from_mesh(**mesh))
    modes, rom = tf.solve_modes(state, n=3), tf.reduce(state, tf.ModalBasis(count=2))
    return {
        "case": case, "model": model, "state": state, "modes": modes, "run": run, "folder": folder, "rom": rom,
        "film": film, "rope": rope, "material": material, "mesh": mesh, "hung": hung,
        "swept": tf.sweep(folder / "study.toml", folder / "swept", workers=1),
        "design": tf.design(folder / "study.toml", folder / "designed", workers=1),
    }  # fmt: skip


def doors(t):
    """Each public door with right keywords: name -> (callable, keywords)."""
    state, model, modes, run, case, folder = (t[name] for name in ("state", "model", "modes", "run", "case", "folder"))
    record = run.data.w.sel(probe="A")
    material, mesh = t["material"], t["mesh"]
    short = {"time_step": 0.01, "end_time": 0.02}
    made = tf.pod(run.data, modes=2)
    table = tf.campbell(state, [0.0, 0.1], n=2)
    appendage = tf.appendage_data(modes)
    nodes, triangles = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]
    knots = np.linspace(0, 1, 4)
    fixed = {"rate": 0.1, "duration": 0.1, "axis": (1, 0, 0), "origin": (0, 0, 0)}
    force = {"nodes": [0], "force": lambda t: np.zeros(3), "breaks": (), "direction": None}
    hub = {
        "mass": 1.0,
        "inertia": (1, 1, 1),
        "center": (0, 0, 0),
        "angular_velocity": (0, 0, 0),
        "velocity": (0, 0, 0),
        "attitude": (1, 0, 0, 0),
        "torque": (0, 0, 1),
        "force": None,
        "breaks": (),
        "axes": "free",
    }
    question = {
        "maneuver": tf.Stop(0.1, 0.01),
        "method": tf.Newmark(),
        "adaptive": None,
        "damping": tf.Rayleigh(0.1, 0.0),
        "coupling": tf.Coupling(),
        "inputs": [],
        "probes": {"A": (0, 0)},
        "probe_reading": "interpolate",
        "initial_velocity": None,
        "initial": None,
        "initial_imperfection": 0.0,
        "time_error": True,
        "every": 1,
        "fields": None,
        "frames": 3,
        "tolerance": 1e-6,
        "max_halvings": 2,
        **short,
    }

    asked = {"workers": 1, "scheduler": None, "force": False}

    def bound(kind):
        def door(**given):
            item = kind(**given)
            return tf.simulate(tf.equip(t["hung"], [item]), inputs=[item], **short)

        return door

    def laid(film=lambda **_: t["film"], rope=lambda **_: t["rope"]):
        return lambda **given: tf.solve_prestress(
            tf.Model.from_mesh(**mesh | {"membrane": film(**given), "cable": rope(**given)})
        )

    return {
        "Adaptive": (tf.Adaptive, {"tolerance": 1e-3, "min_step": 1e-4, "max_step": 0.1}),
        "AtRest": (tf.AtRest, {}),
        "BaseAcceleration": (
            tf.BaseAcceleration,
            {"acceleration": 1.0, "duration": 1.0, "profile": "half-sine", "axis": (0, 0, 1)},
        ),
        "BeamSection": (
            tf.BeamSection,
            {
                "material": material,
                "area": 1e-4,
                "inertia_y": 1e-9,
                "inertia_z": 1e-9,
                "torsion_constant": 1e-9,
                "strain": "von-karman",
                "rotary_inertia": False,
                "nonstructural_mass": 0.0,
            },
        ),
        "Bathe": (tf.Bathe, {"split": 0.5}),
        "CableSection": (
            laid(rope=tf.CableSection),
            {
                "material": material,
                "area": 1e-6,
                "strain": "von-karman",
                "slack": False,
                "law": "elastic",
                "nonstructural_mass": 0.0,
            },
        ),
        "CableTemperature": (
            bound(tf.CableTemperature),
            {"change": 1.0, "expansion": 1e-5, "cables": [0], "breaks": ()},
        ),
        "CableTension": (bound(tf.CableTension), {"change": 1.0, "cables": [0], "breaks": ()}),
        "CentralDifference": (tf.CentralDifference, {}),
        "CondensedDifference": (tf.CondensedDifference, {}),
        "Coupling": (tf.Coupling, dict.fromkeys(("gyroscopic", "euler", "centrifugal", "inertial_load"), True)),
        "EdgeForce": (bound(tf.EdgeForce), force | {"nodes": [0, 1]}),
        "EnergyConserving": (tf.EnergyConserving, {}),
        "FreeHub": (tf.FreeHub, hub),
        "GeneralizedAlpha": (tf.GeneralizedAlpha, {"rho_inf": 0.8}),
        "Held": (tf.Held, {"values": 1.0}),
        "HHT": (tf.HHT, {"alpha": 0.05}),
        "Material": (tf.Material, {"youngs_modulus": 1.0, "density": 1.0, "poisson_ratio": 0.3}),
        "MembraneSection": (
            laid(film=tf.MembraneSection),
            {
                "material": material,
                "thickness": 1e-4,
                "strain": "von-karman",
                "law": "elastic",
                "nonstructural_mass": 0.0,
            },
        ),
        "OrthotropicMaterial": (
            tf.OrthotropicMaterial,
            {
                "youngs_modulus": 2.0,
                "density": 1.0,
                "poisson_ratio": 0.3,
                "youngs_modulus_2": 1.0,
                "shear_modulus_12": 0.5,
                "angle": 0.0,
            },
        ),
        "FrameTemperature": (
            bound(tf.FrameTemperature),
            {"change": 1e-3, "expansion": 1e-5, "beams": [0], "breaks": ()},
        ),
        "GravityGradient": (
            tf.GravityGradient,
            {"inertia": np.eye(3), "orbital_rate": 1e-3, "nadir": (0, 0, -1), "orbit_normal": (0, 1, 0)},
        ),
        "gravity_gradient": (
            tf.gravity_gradient,
            {
                "source": state,
                "hub": tf.FreeHub(**hub),
                "orbital_rate": 1e-3,
                "nadir": (0, 0, -1),
                "orbit_normal": (0, 1, 0),
            },
        ),
        "SolarPressure": (
            bound(tf.SolarPressure),
            {"direction": (0, 0, 1), "share": 1.0, "pressure": 1e-6, "specular": 0.1, "diffuse": 0.1, "breaks": ()},
        ),
        "Attachment": (tf.Attachment, {"nodes": (0, 1, 2)}),
        "DistributingLink": (
            tf.DistributingLink,
            {"reference": 0, "nodes": (1, 2), "weights": 1.0, "directions": ("x", "y", "z")},
        ),
        "LinkEquation": (tf.LinkEquation, {"terms": ((0, "x", 1.0), (1, "x", -1.0))}),
        "RigidLink": (tf.RigidLink, {"reference": 0, "nodes": (1, 2), "directions": ("x",)}),
        "Tie": (tf.Tie, {"reference": 0, "nodes": (1,), "directions": ("x",), "axes": None}),
        "Damper": (tf.Damper, {"nodes": (0, 1), "damping": (1.0, 1.0, 1.0), "axes": None, "place": None}),
        "Spring": (tf.Spring, {"nodes": (0, 1), "stiffness": (1.0, 1.0, 1.0), "axes": None, "place": None}),
        "find_form": (tf.find_form, {"model": t["hung"].model, "tolerance": 1e6, "max_iterations": 3}),
        "laminate": (lambda **given: tf.laminate(given["layers"]), {"layers": t["film"]}),
        "report": (
            tf.report,
            {
                "run": run,
                "path": folder / "run.html",
                "other": None,
                "state": state,
                "folder": folder,
                "size": 6.0,
                "names": ("A", "B"),
            },
        ),
        "explore": (
            tf.explore,
            {
                "model": t["rom"],
                "path": folder / "page.html",
                "hub": tf.FreeHub(1.0, (1.0, 1.0, 1.0), axes="x"),
                "actuators": {"wheel": tf.HubTorque("x")},
                "damping": tf.Rayleigh(0.1, 1e-4),
                "law": tf.PD(1.0, 1.0),
                "slew": tf.Slew(0.1, 0.5),
                "title": "film",
            },
        ),
        "animate": (
            tf.animate,
            {
                "run": run,
                "path": folder / "film.gif",
                "magnification": None,
                "turning": True,
                "frames": 2,
                "rate": 20.0,
                "dots": 20,
            },
        ),
        "MembraneTemperature": (
            bound(tf.MembraneTemperature),
            {"change": 1.0, "expansion": 1e-5, "breaks": (), "region": (0.0, 1.0, 0.0, 1.0)},
        ),
        "MeshData": (
            lambda **given: tf.MeshData(**given).model(membrane=t["film"]),
            {
                "nodes": np.array(nodes, float),
                "triangles": np.array(triangles),
                "cables": np.zeros((0, 2), int),
                "beams": np.zeros((0, 2), int),
                "supports": (),
                "groups": {},
                "quads": np.zeros((0, 4), int),
                "beam_orientation": None,
                "masses": (),
            },
        ),
        "Modal": (tf.Modal, {"ratio": 0.01, "modes": 3}),
        "ModalBasis": (
            tf.ModalBasis,
            {
                "directions": ("z",),
                "count": 3,
                "threshold": 1e-3,
                "candidates": 10,
                "static_correction": True,
                "derivatives": "condensed",
            },
        ),
        "Model": (
            tf.Model,
            {
                "nodes": model.nodes,
                "groups": model.groups,
                "supports": model.supports,
                "prestress_mode": "uniform",
                "masses": (),
                "links": (),
                "springs": (),
                "dampers": (),
                "selections": {},
            },
        ),
        "Model.from_mesh": (tf.Model.from_mesh, mesh),
        "Newmark": (tf.Newmark, {"gamma": 0.5, "beta": 0.25}),
        "NodalForce": (bound(tf.NodalForce), force),
        "PodBasis": (tf.PodBasis, {"data": run.data, "count": 2, "lost": 1e-5, "derivatives": "condensed"}),
        "PiezoFilm": (
            bound(tf.PiezoFilm),
            {"coefficient": 1e-11, "field": 1.0, "region": (0.0, 1.0, 0.0, 1.0), "breaks": ()},
        ),
        "PiezoPair": (bound(tf.PiezoPair), {"beams": [0], "moment": 0.1, "axis": "y", "breaks": ()}),
        "PointMass": (tf.PointMass, {"node": 0, "mass": 1.0, "inertia": 0.1, "offset": (0.1, 0.0, 0.0)}),
        "Pressure": (bound(tf.Pressure), {"pressure": 1.0, "breaks": ()}),
        "PressureLoad": (tf.PressureLoad, {"system": state.system, "pressure": 1.0}),
        "Rayleigh": (tf.Rayleigh, {"alpha": 0.1, "beta": 0.1}),
        "Sequence": (tf.Sequence, {"steps": (tf.Slew(0.1, 1.0), tf.Slew(-0.1, 1.0)), "holds": (0.1,)}),
        "Slew": (
            tf.Slew,
            {
                "angle": 0.1,
                "duration": 5.0,
                "profile": "input-shaped",
                "axis": (1, 0, 0),
                "origin": (0, 0, 0),
                "frequency": 1.0,
                "damping_ratio": 0.01,
                "shaper": "ZVD",
                "base": "versine",
            },
        ),
        "SpinUp": (tf.SpinUp, fixed | {"profile": "versine", "initial_rate": 0.0}),
        "StayCable": (
            bound(tf.StayCable),
            {"point": (0.5, 0.5), "anchor": (0.0, 0.0, 1.0), "tension": 1e-3, "breaks": ()},
        ),
        "Stop": (tf.Stop, fixed),
        "Support": (tf.Support, {"nodes": (0, 1), "directions": ("x",)}),
        "SupportMotion": (
            bound(tf.SupportMotion),
            {
                "nodes": state.model.supports[0].nodes[:1],
                "direction": (0.0, 0.0, 1.0),
                "motion": 1.0,
                "quantity": "acceleration",
                "breaks": (),
            },
        ),
        "Tabulated": (
            tf.Tabulated,
            {
                "times": knots,
                "rates": 0.1 * knots,
                "axis": (1, 0, 0),
                "origin": (0, 0, 0),
                "quaternions": None,
                "accelerations": None,
                "ends": "free",
            },
        ),
        "TensionGroup": (
            bound(tf.TensionGroup),
            {"cables": [0], "change": 0.1, "command": "length", "stiffness": 1.0, "share": "equal", "breaks": ()},
        ),
        "TimeTable": (tf.TimeTable, {"times": knots, "values": knots}),
        "TransientProblem": (tf.TransientProblem, {"plant": state, **question}),
        "WilsonTheta": (tf.WilsonTheta, {"theta": 1.4}),
        "amplitude": (tf.amplitude, {"record": record}),
        "appendage_data": (tf.appendage_data, {"modes": modes, "point": (0, 0, 0), "damping": None}),
        "attitude": (tf.attitude, {"maneuver": tf.Stop(0.1, 0.1), "times": [0.0, 1.0], "initial": (1, 0, 0, 0)}),
        "build_model": (tf.build_model, {"case": case}),
        "campbell": (
            tf.campbell,
            {
                "state": state,
                "rates": [0.0, 0.1],
                "axis": (1, 0, 0),
                "n": 2,
                "origin": (0, 0, 0),
                "coupling": None,
                "damping": None,
            },
        ),
        "dominant_frequency": (
            tf.dominant_frequency,
            {"record": record, "pad": "none", "length": 1.0, "after": 0.0, "band": 0.0},
        ),
        "dominant_shape": (tf.dominant_shape, {"pod_data": made, "energy": 0.5}),
        "dynamic_mass": (tf.dynamic_mass, {"data": appendage, "frequencies": [0.1]}),
        "equip": (tf.equip, {"state": state, "inputs": []}),
        "hyper_reduce": (
            tf.hyper_reduce,
            {
                "state": state,
                "data": run.data,
                "transverse": 1,
                "in_plane": 1,
                "lost": (1e-3, 1e-3),
                "tolerance": 0.1,
                "training_states": 5,
                "inputs": (),
            },
        ),
        "linear_solver": (lambda name: tf.linear_solver(name).__enter__(), {"name": "auto"}),
        "load": (tf.load, {"path": folder / "run.nc"}),
        "load_case": (tf.load_case, {"path": folder / "film.toml", "overrides": ()}),
        "mac": (tf.mac, {"a": modes.to_dataset()["shape"], "b": modes.to_dataset()["shape"]}),
        "mac_table": (tf.mac_table, {"shape": modes.to_dataset()["shape"][0], "modes": modes.to_dataset(), "count": 2}),
        "maneuver_end": (tf.maneuver_end, {"run": run.data}),
        "membrane_states": (tf.membrane_states, {"source": state, "q": np.zeros(state.system.size)}),
        "pod": (tf.pod, {"data": run.data, "modes": 2, "mass": None, "energy": 0.9}),
        "read_mesh": (
            tf.read_mesh,
            {"path": folder / "none.inp", "names": None, "unit_length": 1.0, "unit_mass": None, "step": None},
        ),
        "reduce": (tf.reduce, {"state": state, "basis": tf.ModalBasis(count=2), "weak_field": 1e-5, "inputs": ()}),
        "run_case": (tf.run_case, {"case": case, "checkpoint": None, "seconds": 60.0}),
        "control_case": (tf.control_case, {"case": case.replaced(**LOOP), "checkpoint": None, "seconds": 60.0}),
        "save": (tf.save, {"dataset": run.data, "path": folder / "again.nc"}),
        "save_appendage": (tf.save_appendage, {"data": appendage, "path": folder / "appendage.json"}),
        "scalogram": (
            tf.scalogram,
            {"record": record, "frequencies": [2.0, 3.0, 5.0], "bandwidth": 3.0, "center": 1.0},
        ),
        "ruze_loss": (tf.ruze_loss, {"rms": 1e-3, "frequency": 1e10}),
        "settling_time": (tf.settling_time, {"record": record, "tolerance": 1e-3, "after": 0.0}),
        "surface": (tf.surface, {"run": run}),
        "simulate": (tf.simulate, {"state": state, **question}),
        "simulate (reduced)": (tf.simulate, {"state": t["rom"], **question}),
        "solve_modes": (tf.solve_modes, {"state": state, "n": 2, "about": None, "hub": None}),
        "solve_prestress": (tf.solve_prestress, {"model": model, "check": True}),
        "solve_spinning_modes": (
            tf.solve_spinning_modes,
            {
                "state": state,
                "angular_velocity": (0.1, 0, 0),
                "origin": (0, 0, 0),
                "n": 2,
                "coupling": None,
                "damping": None,
            },
        ),
        "solve_static": (
            tf.solve_static,
            {
                "state": state,
                "load": np.zeros(state.system.size),
                "extra": None,
                "tolerance": 1e-9,
                "forces": None,
                "pressure": None,
                "steps": 1,
                "start": None,
            },
        ),
        "spectrum": (tf.spectrum, {"record": record, "pad": "none", "length": 1.0, "after": 0.0, "remove_mean": True}),
        "tune_pretension": (
            tf.tune_pretension,
            {"model": model, "frequencies": [30.0], "modes": [1], "tolerance": 1e-2, "max_iterations": 9},
        ),
        "write_csv": (tf.write_csv, {"dataset": run.data, "path": folder / "run.csv"}),
        "write_vtu": (tf.write_vtu, {"dataset": run.data, "directory": folder / "vtu", "name": "run"}),
        "plot_campbell": (plot.plot_campbell, {"table": table, "orders": (1,), "highest": 10.0}),
        "plot_loop": (plot.plot_loop, {"run": tf.control_case(case.replaced(**LOOP))}),
        "plot_modes": (plot.plot_modes, {"modes": modes, "count": 1, "columns": 1}),
        "plot_scalogram": (
            plot.plot_scalogram,
            {"run": run, "probe": "A", "component": "w", "frequencies": None, "bandwidth": 3.0, "floor": -40.0},
        ),
        "plot_shapes": (plot.plot_shapes, {"run": run, "times": [0.0], "magnification": 10.0, "columns": 1}),
        "plot_spectrum": (
            plot.plot_spectrum,
            {
                "run": run,
                "probes": ["A"],
                "component": "w",
                "natural_frequencies": None,
                "highest": 10.0,
                "length": 1.0,
            },
        ),
        "plot_surface": (plot.plot_surface, {"run": run, "tolerance": 1e-5}),
        "plot_time_history": (
            plot.plot_time_history,
            {"runs": run, "probes": ["A"], "component": "w", "span": (0.0, 0.1)},
        ),
        "save_figure": (
            plot.save_figure,
            {"figure": plot.plot_modes(modes.to_dataset(), 1, 1), "stem": folder / "figure", "formats": ("png",)},
        ),
        "load_run": (tf.load_run, {"path": folder / "run.nc"}),
        "load_study": (tf.load_study, {"path": folder / "study.toml"}),
        "sweep": (tf.sweep, asked | {"study": folder / "study.toml", "directory": folder / "study"}),
        "design": (
            tf.design,
            asked | {"study": folder / "study.toml", "directory": folder / "design", "trials": 1},
        ),
        "plot_study": (plot.plot_study, {"study": t["swept"], "measures": ["surface.rms"]}),
        "plot_design": (plot.plot_design, {"design": t["design"]}),
        **control_doors(t),
    }


WRONG = {
    "an object": Wrong(), "a class": tf.Stop, "text": "?", "NaN": math.nan, "negative": -1.0, "empty list": [],
    "texts": ["?"], "objects": [Wrong()], "function of one": lambda time: 0.0, "bytes": b"?", "complex": 1j,
    "NaNs": np.full(3, np.nan), "cube": np.zeros((2, 2, 2)), "mapping": {"?": "?"}, "Dataset": xr.Dataset(),
    "huge": 10**400,
}  # fmt: skip


def refused(call, right, parameter, wrong):
    """The package's error for a wrong object; None if it was taken."""
    try:
        call(**right | {parameter: wrong})
    except tf.TautflexError as error:
        return error
    except OSError:  # documented where files are written
        assert isinstance(wrong, str | bytes)
    return None


def test_every_door_is_walked(things):
    names = {name.partition(" ")[0].partition(".")[0] for name in doors(things)}
    public = {name for name in dir(tf) if callable(getattr(tf, name)) and not name.endswith(("Error", "Warning"))}
    assert public - set(INNER.split()) <= names
    assert {name for name in plot.__all__ if not name.startswith("save_")} <= names
    for name, (call, right) in doors(things).items():
        own = {item for item, how in inspect.signature(call).parameters.items() if how.kind is not how.VAR_KEYWORD}
        assert own - {"progress", "throw", "schema", "prestress_stated"} <= set(right), name


@pytest.mark.slow
def test_only_the_errors_of_the_package_come_out(things, tmp_path, monkeypatch):
    """And a bare object is refused everywhere, by the name of the parameter."""
    monkeypatch.chdir(tmp_path)
    others = {name: things[name] for name in ("model", "state", "modes", "run")}
    for name, (call, right) in doors(things).items():
        if name != "read_mesh":
            call(**right)
        for parameter in right:
            for kind, wrong in (WRONG | others).items():
                error = refused(call, right, parameter, wrong)
                if kind == "an object" and (name, parameter) not in ANY:
                    assert error is not None, f"{name}({parameter}) takes any object"
                if error is not None:
                    assert len(str(error)) < 600, error
                    assert "object at 0x" not in str(error), error


def test_who_is_told_of_progress_is_a_function(things):
    case, law = parse_case(FILM_CASE), tf.PD(1.0, 1.0)
    told = {
        name: (call, right)
        for name, (call, right) in doors(things).items()
        if "progress" in inspect.signature(call).parameters
    } | {
        "train": (tf.train, {"case": case}),
        "evaluate": (tf.evaluate, {"laws": {"pd": law}, "case": case}),
        "tune_law": (tf.tune_law, {"law": law, "case": case}),
    }
    assert {"simulate", "campbell", "close_loop", "run_case", "control_case", "sweep", "design"} <= set(told)
    for call, right in told.values():
        for wrong in (3, Wrong(), lambda fraction: None):
            with pytest.raises(tf.InputError, match=r"^progress: expected a function of \(fraction, message\)"):
                call(**right | {"progress": wrong})


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda t: tf.simulate(t["model"], time_step=0.01, end_time=0.1), "state: .*solve_prestress"),
        (lambda t: tf.simulate(t["state"], tf.Stop, time_step=0.01, end_time=0.1), r"maneuver: .*write Stop\(...\)"),
        (
            lambda t: tf.simulate(t["state"], time_step=0.01, end_time=0.1, method=tf.Newmark),
            r"method: .*Newmark\(...\)",
        ),
        (lambda t: tf.simulate(t["state"], time_step="0.01", end_time=0.1), "time_step: .*'0.01'"),
        (lambda t: tf.simulate(t["state"], time_step=math.nan, end_time=0.1), "time_step: .*nan"),
        (
            lambda t: tf.simulate(t["state"], time_step=0.01, end_time=0.1, inputs=tf.NodalForce([0], (0, 0, 1))),
            "inputs: ",
        ),
        (lambda t: tf.solve_modes(t["model"]), "state: .*solve_prestress"),
        (lambda t: tf.solve_modes(t["state"], "3"), "n: "),
        (lambda t: tf.reduce(t["model"]), "state: .*solve_prestress"),
        (lambda t: tf.solve_static(t["state"], tolerance=math.nan), "tolerance: "),
        (lambda t: tf.solve_static(t["state"], start=np.zeros(2)), "start: expected shape"),
        (lambda t: tf.solve_static(t["state"], load="a"), "load: "),
        (lambda t: tf.solve_static(t["state"], pressure=1.0), "pressure: .*PressureLoad"),
        (lambda t: tf.PressureLoad("a", 1.0), "system: .*solve_prestress"),
        (lambda t: tf.FreeHub(1.0, (1, 1, 1), breaks=0.1), "breaks: "),
        (lambda t: tf.FreeHub(1.0, (1, 1, 5)), "inertia: .*sum of the others"),
        (lambda t: tf.FreeHub(1.0, (1, 1, 1), torque=lambda time: (0, 0, 0)), r"torque: .*\(time, state\)"),
        (lambda t: tf.FreeHub(-1.0, (1, 1, 1)), "mass: "),
        (lambda t: plot.plot_time_history(t["still"]), "run: .*probes="),
        (lambda t: plot.plot_modes(t["run"]), "modes: .*solve_modes"),
        (lambda t: plot.plot_shapes(t["still"]), "run: .*fields="),
        (lambda t: tf.amplitude(t["run"]), "record: "),
        (lambda t: tf.Material("3e9", 1500.0), "youngs_modulus: .*'3e9'"),
    ],
)
def test_messages_name_the_argument_and_what_to_call(things, call, words):
    still = tf.simulate(things["state"], time_step=0.01, end_time=0.02)
    with pytest.raises(tf.InputError, match=words):
        call(things | {"still": still})


def test_figures_refuse_results_of_another_kind_in_one_line(things):
    """A result without what is drawn, or with other dimensions: what is missing, and where it comes from."""
    run, modes = things["run"].data, things["modes"].to_dataset()
    of_a_run = {
        "plot_time_history": plot.plot_time_history,
        "plot_spectrum": plot.plot_spectrum,
        "plot_scalogram": lambda data: plot.plot_scalogram(data, "A"),
        "plot_shapes": plot.plot_shapes,
    }
    kinds = {
        "modes": modes,
        "table": tf.campbell(things["state"], [0.0, 0.1], n=2),
        "spectrum": tf.spectrum(run["w"][:, 0]),
        "empty": modes[[]],
        "shape without components": modes.assign(shape=modes["shape"][..., 0]),
        "run without probes": run.assign({name: run[name][:, 0] for name in "uvw"}).isel(field_time=[]),
        "one field": run.isel(field_time=0, probe=0),
    }
    remedies = dict.fromkeys(of_a_run, r"simulate\(state|simulate with") | {
        "plot_modes": r"solve_modes\(state\)",
        "plot_campbell": r"campbell\(state, rates\)",
    }
    drawable = {("plot_modes", "modes"), ("plot_campbell", "table")}
    calls = of_a_run | {"plot_modes": plot.plot_modes, "plot_campbell": plot.plot_campbell}
    for (name, call), (kind, data) in itertools.product(calls.items(), kinds.items()):
        if (name, kind) in drawable:
            continue
        with pytest.raises(tf.InputError, match=remedies[name]) as error:
            call(data)
        assert "\n" not in str(error.value), (name, kind)


@pytest.mark.jax
def test_a_batch_refuses_texts(things):
    with pytest.raises(tf.InputError, match="tension_x"):
        tf.Batch(things["rom"]).simulate({"tension_x": "a"}, time_step=0.01, end_time=0.1)


def test_no_inputs_are_none_and_figures_take_what_the_solvers_give(things):
    run, modes = things["run"], things["modes"]
    assert tf.TransientProblem(things["state"], time_step=0.01, end_time=0.1, inputs=None).inputs == ()
    assert plot.plot_modes(modes).axes
    assert plot.plot_time_history({"one": run, "two": run.data}).axes
    assert tf.maneuver_end(run) == tf.maneuver_end(run.data)
    assert tf.pod(run, modes=1).equals(tf.pod(run.data, modes=1))
