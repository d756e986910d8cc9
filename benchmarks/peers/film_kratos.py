"""The film with Kratos: ``film_kratos.py PROBLEM.npz RESULT.npz`` (files: see film_problem.py).

``MembraneElement3D3N`` with prestress, consistent mass, Newmark's trapezoidal rule (Bossak with alpha = 0), Newton's
method and a sparse direct solver. The dofs, the sparsity pattern and the scheme are set up once.
"""

from __future__ import annotations

import json
import sys
import time
from importlib.metadata import version

import KratosMultiphysics as Kratos
import numpy as np
from film_files import film_result
from KratosMultiphysics import LinearSolversApplication  # noqa: F401  registers its solvers
from KratosMultiphysics import StructuralMechanicsApplication as Structural
from KratosMultiphysics.python_linear_solver_factory import ConstructSolver

REBUILD = {"newton": 2, "modified": 1}


def film(problem: dict[str, np.ndarray]):
    """Model part with nodes, elements, supports and the state at the start."""
    model = Kratos.Model()
    part = model.CreateModelPart("film")
    part.SetBufferSize(2)
    for variable in (Kratos.DISPLACEMENT, Kratos.REACTION, Kratos.VELOCITY, Kratos.ACCELERATION):
        part.AddNodalSolutionStepVariable(variable)
    part.AddNodalSolutionStepVariable(Kratos.VOLUME_ACCELERATION)
    part.ProcessInfo[Kratos.DOMAIN_SIZE] = 3
    part.ProcessInfo[Structural.RAYLEIGH_ALPHA] = 0.0
    part.ProcessInfo[Structural.RAYLEIGH_BETA] = 0.0
    part.ProcessInfo[Kratos.COMPUTE_LUMPED_MASS_MATRIX] = False
    properties = part.CreateNewProperties(1)
    properties[Kratos.YOUNG_MODULUS] = float(problem["young"])
    properties[Kratos.POISSON_RATIO] = float(problem["poisson"])
    properties[Kratos.DENSITY] = float(problem["density"])
    properties[Kratos.THICKNESS] = float(problem["thickness"])
    properties[Structural.PRESTRESS_VECTOR] = Kratos.Vector([float(value) for value in problem["stress"]])
    properties[Kratos.CONSTITUTIVE_LAW] = Structural.LinearElasticPlaneStress2DLaw()
    for number, (x, y, z) in enumerate(problem["nodes"], 1):
        part.CreateNewNode(number, float(x), float(y), float(z))
    for number, corners in enumerate(problem["triangles"], 1):
        element = part.CreateNewElement(
            "MembraneElement3D3N", number, [int(corner) + 1 for corner in corners], properties
        )
        # Equal stress in all directions needs no axes, which spares Kratos their transformation.
        if problem["stress"][0] != problem["stress"][1] or problem["stress"][2] != 0.0:
            element.SetValue(Structural.LOCAL_PRESTRESS_AXIS_1, Kratos.Array3([1.0, 0.0, 0.0]))
    utility = Kratos.VariableUtils()
    for variable, reaction in (
        (Kratos.DISPLACEMENT_X, Kratos.REACTION_X),
        (Kratos.DISPLACEMENT_Y, Kratos.REACTION_Y),
        (Kratos.DISPLACEMENT_Z, Kratos.REACTION_Z),
    ):
        utility.AddDof(variable, reaction, part)
        for node in problem["fixed"]:
            part.GetNode(int(node) + 1).Fix(variable)
    for number, velocity in enumerate(problem["velocity"], 1):
        part.GetNode(number).SetSolutionStepValue(Kratos.VELOCITY, 0, Kratos.Array3([float(v) for v in velocity]))
    return model, part


def newton(part, tolerance: float, solver: str, rebuild: int, builder: str):
    """Newton's method on the trapezoidal rule."""
    linear = ConstructSolver(Kratos.Parameters(json.dumps({"solver_type": solver})))
    scheme = Kratos.ResidualBasedBossakDisplacementScheme(0.0, 0.25)
    build = {
        "block": Kratos.ResidualBasedBlockBuilderAndSolver,
        "elimination": Kratos.ResidualBasedEliminationBuilderAndSolver,
    }[builder](linear)
    criterion = Kratos.DisplacementCriteria(tolerance, 1e-16)
    strategy = Kratos.ResidualBasedNewtonRaphsonStrategy(part, scheme, criterion, build, 30, False, False, False)
    strategy.SetRebuildLevel(rebuild)
    strategy.SetEchoLevel(0)
    criterion.SetEchoLevel(0)
    strategy.Check()
    strategy.Initialize()
    return strategy


def run(problem: dict[str, np.ndarray], tolerance: float, solver: str, method: str, builder: str):
    """Record of the probe and what it cost."""
    Kratos.Logger.GetDefaultOutput().SetSeverity(Kratos.Logger.Severity.WARNING)
    began = time.process_time()
    _model, part = film(problem)
    strategy = newton(part, tolerance, solver, REBUILD[method], builder)
    step, count = float(problem["step"]), int(problem["count"])
    probe = part.GetNode(int(problem["probe"]) + 1)
    record = np.zeros((count + 1, 3))
    clock = np.zeros((count + 1, 2))
    iterations = 0
    ready = time.process_time()
    for number in range(1, count + 1):
        part.CloneTimeStep(number * step)
        part.ProcessInfo[Kratos.STEP] = number
        strategy.InitializeSolutionStep()
        strategy.Predict()
        if not strategy.SolveSolutionStep():
            raise RuntimeError(f"Kratos did not converge in step {number}")
        strategy.FinalizeSolutionStep()
        iterations += part.ProcessInfo[Kratos.NL_ITERATION_NUMBER]
        record[number] = probe.GetSolutionStepValue(Kratos.DISPLACEMENT)
        clock[number] = number, time.process_time() - ready
    return film_result(
        record,
        clock,
        ready - began,
        version=version("KratosMultiphysics"),
        solver=f"{solver}, {method}, {builder}",
        iterations=iterations,
        factorizations=iterations,
    )


if __name__ == "__main__":
    problem = dict(np.load(sys.argv[1]))
    options = sys.argv[3:] or ["1e-4", "LinearSolversApplication.sparse_lu", "newton", "block"]
    np.savez(sys.argv[2], **run(problem, float(options[0]), *options[1:]))
