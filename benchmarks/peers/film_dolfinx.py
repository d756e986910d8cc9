"""The film with DOLFINx: ``film_dolfinx.py PROBLEM.npz RESULT.npz PATIENCE`` (files: see film_problem.py).

Same weak form: P1 or P2 displacements in space on a flat film, Green-Lagrange membrane strain, plane stress, initial
stress, consistent mass, trapezoidal rule. Forms are compiled with full optimization and natively, the mass is assembled
once, the tangent is assembled and factorized only when the last factors would need more than PATIENCE further
iterations (0: in every iteration, which is Newton's method). The Cholesky factors are PETSc's own or, where they were
faster in trials, MUMPS's.
"""

from __future__ import annotations

import sys
import time

import numpy as np
import ufl
from dolfinx import __version__, fem, mesh
from film_files import corners, film_result, matched
from mpi4py import MPI
from petsc4py import PETSc

# Iterations of a step after which a run is given up.
MOST = 100
COMPILED = {"cffi_extra_compile_args": ["-O3", "-march=native", "-ffast-math"], "cffi_libraries": ["m"]}


def forms(problem, space, displacement):
    """Internal virtual work, its derivative and the mass form."""
    test, trial = ufl.TestFunction(space), ufl.TrialFunction(space)
    young, poisson = float(problem["young"]), float(problem["poisson"])
    thickness = float(problem["thickness"])
    slope = ufl.grad(displacement)
    plane = ufl.as_tensor([[slope[i, j] for j in range(2)] for i in range(2)])
    strain = 0.5 * (plane + plane.T + slope.T * slope)
    sx, sy, sxy = (float(value) for value in problem["stress"])
    initial = ufl.as_tensor([[sx, sxy], [sxy, sy]])
    elastic = young / (1.0 - poisson**2) * ((1.0 - poisson) * strain + poisson * ufl.tr(strain) * ufl.Identity(2))
    # One point of a linear triangle, three of a quadratic one.
    points = ufl.dx(metadata={"quadrature_degree": 2 * (space.ufl_element().degree() - 1)})
    energy = thickness * ufl.inner(initial + 0.5 * elastic, strain) * points
    work = ufl.derivative(energy, displacement, test)
    tangent = ufl.derivative(work, displacement, trial)
    mass = float(problem["density"]) * thickness * ufl.inner(trial, test) * ufl.dx
    return [fem.form(part, jit_params=COMPILED) for part in (work, tangent, mass)]


class Film:
    """Matrices and vectors of the film on the free unknowns' full numbering, held rows replaced by one."""

    def __init__(self, problem) -> None:
        order = 1 if problem["triangles"].shape[1] == 3 else 2
        element = ufl.VectorElement("Lagrange", ufl.triangle, order, dim=3)
        plane = ufl.Mesh(ufl.VectorElement("Lagrange", ufl.triangle, 1))
        points, triangles = corners(problem)
        domain = mesh.create_mesh(MPI.COMM_SELF, triangles, points, plane)
        self.space = fem.FunctionSpace(domain, element)
        self.displacement = fem.Function(self.space)
        self._work, self._tangent, mass = forms(problem, self.space, self.displacement)
        self.node_block = matched(self.space.tabulate_dof_coordinates()[:, :2], problem["nodes"][:, :2])
        self.held = np.sort(3 * self.node_block[problem["fixed"], None] + np.arange(3)).ravel().astype(np.int32)
        self.support = fem.dirichletbc(
            fem.Function(self.space), np.sort(self.node_block[problem["fixed"]]).astype(np.int32)
        )
        self.mass = fem.petsc.assemble_matrix(mass, bcs=[self.support], diagonal=0.0)
        self.mass.assemble()
        self.tangent = fem.petsc.create_matrix(self._tangent)
        self.internal = fem.petsc.create_vector(self._work)
        self.at = self.displacement.vector

    def force(self):
        """Internal forces at the displacement, zero at held unknowns."""
        with self.internal.localForm() as local:
            local.set(0.0)
        fem.petsc.assemble_vector(self.internal, self._work)
        self.internal.array[self.held] = 0.0
        return self.internal

    def effective(self, factor: float):
        """Tangent + factor x mass at the displacement."""
        self.tangent.zeroEntries()
        fem.petsc.assemble_matrix(self.tangent, self._tangent, bcs=[self.support])
        self.tangent.assemble()
        self.tangent.axpy(factor, self.mass, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        return self.tangent


def direct_solver(matrix):
    """PETSc's direct solver with the faster package for this size, and its name."""
    # Milliseconds per factorization and step of Newton: 6, 10 with 2 223 unknowns, 1060, 450 with 37 683.
    package = "petsc" if matrix.getSize()[0] < 8000 else "mumps"
    solver = PETSc.KSP().create(MPI.COMM_SELF)
    solver.setOperators(matrix)
    solver.setType("preonly")
    solver.getPC().setType("cholesky")
    solver.getPC().setFactorSolverType(package)
    solver.getPC().setReusePreconditioner(True)
    return solver, package


class Stepper:
    """Trapezoidal rule; the iteration keeps its factors for as long as they serve."""

    def __init__(self, film, step, tolerance, patience, solver) -> None:
        self.film, self.step, self.tolerance, self.patience, self.solver = film, step, tolerance, patience, solver
        self.residual, self.increment, self.guess = (film.at.duplicate() for _ in range(3))
        # Uses of the present factors.
        self.iterations = self.factorizations = self.age = 0

    def refresh(self) -> None:
        """Assemble and factorize the tangent at the displacement."""
        self.film.effective(4.0 / self.step**2)
        self.solver.getPC().setReusePreconditioner(False)
        self.solver.setOperators(self.film.tangent)
        self.solver.setUp()
        self.solver.getPC().setReusePreconditioner(True)
        self.factorizations, self.age = self.factorizations + 1, 0

    def error(self, known) -> float:
        """Residual ``M (4/h^2 u - known) + f(u)`` and its norm over that of the internal forces."""
        film = self.film
        force = film.force()
        self.guess.waxpy(-1.0, known, film.at)
        film.mass.mult(self.guess, self.residual)
        self.residual.scale(4.0 / self.step**2)
        self.residual.axpy(1.0, force)
        return self.residual.norm() / max(force.norm(), 1e-300)

    def advance(self, velocity, acceleration, known) -> None:
        """Take one step; the vectors are brought to its end."""
        film, h = self.film, self.step
        # known = u + h v + h^2/4 a: the inertia force of the end is 4/h^2 M (u_end - known).
        film.at.copy(known)
        known.axpy(h, velocity)
        known.axpy(0.25 * h**2, acceleration)
        # First guess: the acceleration stays.
        film.at.axpy(h, velocity)
        film.at.axpy(0.5 * h**2, acceleration)
        before, first = self.error(known), self.iterations
        while before > self.tolerance:
            if self.patience == 0 or self.factorizations == 0:
                self.refresh()
            self.solver.solve(self.residual, self.increment)
            film.at.axpy(-1.0, self.increment)
            self.iterations += 1
            self.age += 1
            after = self.error(known)
            if self.iterations - first > MOST:
                raise RuntimeError(f"no convergence within {MOST} iterations of a step")
            if self.patience and after > self.tolerance:
                left = np.log(after / self.tolerance) / np.log(before / after) if after < before else np.inf
                if left > self.patience:
                    if after >= before and self.age > 1:
                        film.at.axpy(1.0, self.increment)
                    self.refresh()
                    after = self.error(known)
            before = after
        # a_end = 4/h^2 (u_end - known); v_end = v + h/2 (a + a_end)
        velocity.axpy(0.5 * h, acceleration)
        acceleration.waxpy(-1.0, known, film.at)
        acceleration.scale(4.0 / h**2)
        velocity.axpy(0.5 * h, acceleration)


def run(problem, patience):
    """Record of the probe and what it cost."""
    began = time.process_time()
    film = Film(problem)
    count = int(problem["count"])
    velocity, acceleration, known = (film.at.duplicate() for _ in range(3))
    velocity.array.reshape(-1, 3)[film.node_block] = problem["velocity"]
    # The flat film under uniform stress is in equilibrium: the acceleration at the start is zero.
    acceleration.set(0.0)
    probe = film.node_block[int(problem["probe"])]
    record = np.zeros((count + 1, 3))
    solver, package = direct_solver(film.tangent)
    stepper = Stepper(film, float(problem["step"]), float(problem["tolerance"]), patience, solver)
    clock = np.zeros((count + 1, 2))
    ready = time.process_time()
    for number in range(1, count + 1):
        stepper.advance(velocity, acceleration, known)
        record[number] = film.at.array[3 * probe : 3 * probe + 3]
        clock[number] = number, time.process_time() - ready
    return film_result(
        record,
        clock,
        ready - began,
        version=__version__,
        solver=f"Cholesky ({package}), " + (f"factors kept while they serve ({patience})" if patience else "Newton"),
        iterations=stepper.iterations,
        factorizations=stepper.factorizations,
    )


if __name__ == "__main__":
    np.savez(sys.argv[2], **run(dict(np.load(sys.argv[1])), int(sys.argv[3])))
