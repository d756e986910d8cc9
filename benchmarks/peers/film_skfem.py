"""The film with scikit-fem: ``film_skfem.py PROBLEM.npz RESULT.npz PATIENCE`` (files: see film_problem.py).

Same weak form as `film_dolfinx`, P1 or P2. Forms are evaluated by numpy on whole arrays, as scikit-fem does, the
factors are SuperLU's through SciPy, ordered for symmetric patterns, and kept while they serve (PATIENCE as there).
"""

from __future__ import annotations

import sys
import time

import numpy as np
import skfem
from film_files import corners, film_result, matched
from scipy.sparse.linalg import splu

# Iterations of a step after which a run is given up.
MOST = 100


class Film:
    """Mass, internal forces and tangent on the free unknowns."""

    def __init__(self, problem) -> None:
        points, triangles = corners(problem)
        mesh = skfem.MeshTri(points.T, triangles.T)
        linear = problem["triangles"].shape[1] == 3
        element = skfem.ElementVector(skfem.ElementTriP1() if linear else skfem.ElementTriP2(), 3)
        # One point of a linear triangle, three of a quadratic one; the mass is exact.
        self.basis = skfem.Basis(mesh, element, intorder=0 if linear else 2)
        exact = skfem.Basis(mesh, element, intorder=2 if linear else 4)
        self.young, self.poisson, self.thickness = (float(problem[name]) for name in ("young", "poisson", "thickness"))
        sx, sy, sxy = problem["stress"]
        self.initial = np.array([[sx, sxy], [sxy, sy]])[:, :, None, None]
        unknowns = np.hstack([self.basis.nodal_dofs, self.basis.facet_dofs]) if not linear else self.basis.nodal_dofs
        self.unknowns = unknowns[:, matched(self.basis.doflocs[:, unknowns[0]].T, problem["nodes"][:, :2])].T
        self.free = np.setdiff1d(np.arange(self.basis.N), self.unknowns[problem["fixed"]].ravel())
        areal = float(problem["density"]) * self.thickness
        mass = skfem.BilinearForm(lambda u, v, _: areal * np.einsum("i...,i...->...", u, v))
        self.mass = self._reduced(mass.assemble(exact))
        self._work, self._tangent = skfem.LinearForm(self._virtual), skfem.BilinearForm(self._slope)

    def _reduced(self, matrix):
        return matrix.tocsr()[self.free][:, self.free].tocsc()

    def _state(self, displacement):
        """Slopes (3, 2, ...) and stresses (2, 2, ...) of a displacement of all unknowns."""
        slope = self.basis.interpolate(displacement).grad
        strain = 0.5 * (slope[:2] + slope[:2].swapaxes(0, 1) + np.einsum("ki...,kj...->ij...", slope, slope))
        return {"slope": slope, "stress": self.initial + self._elastic(strain)}

    def _elastic(self, strain):
        trace = self.poisson * (strain[0, 0] + strain[1, 1])
        stress = (1.0 - self.poisson) * strain
        stress[0, 0] += trace
        stress[1, 1] += trace
        return self.young / (1.0 - self.poisson**2) * stress

    @staticmethod
    def _varied(test, slope):
        """Variation of the strain, symmetric part (2, 2, ...)."""
        full = test.grad[:2] + np.einsum("ki...,kj...->ij...", test.grad, slope)
        return 0.5 * (full + full.swapaxes(0, 1))

    def _virtual(self, v, w):
        return self.thickness * np.einsum("ij...,ij...->...", w["stress"], self._varied(v, w["slope"]))

    def _slope(self, u, v, w):
        elastic = self._elastic(self._varied(u, w["slope"]))
        linear = np.einsum("ij...,ij...->...", elastic, self._varied(v, w["slope"]))
        turned = np.einsum("ki...,ij...,kj...->...", u.grad, w["stress"], v.grad)
        return self.thickness * (linear + turned)

    def force(self, displacement):
        """Internal forces on the free unknowns."""
        return self._work.assemble(self.basis, **self._state(displacement))[self.free]

    def effective(self, displacement, factor):
        """Tangent + factor x mass on the free unknowns."""
        return self._reduced(self._tangent.assemble(self.basis, **self._state(displacement))) + factor * self.mass


class Stepper:
    """Trapezoidal rule; the iteration keeps its factors for as long as they serve."""

    def __init__(self, film, problem, patience) -> None:
        self.film, self.patience = film, patience
        self.step, self.tolerance = float(problem["step"]), float(problem["tolerance"])
        self.displacement = np.zeros(film.basis.N)
        velocity = np.zeros(film.basis.N)
        velocity[film.unknowns] = problem["velocity"]
        self.velocity, self.acceleration = velocity[film.free], np.zeros(len(film.free))
        self.factors = None
        # Uses of the present factors.
        self.iterations = self.factorizations = self.age = 0

    def refresh(self) -> None:
        """Assemble and factorize the tangent at the displacement."""
        matrix = self.film.effective(self.displacement, 4.0 / self.step**2)
        self.factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        self.factorizations, self.age = self.factorizations + 1, 0

    def residual(self, known):
        """Residual of the end of the step and its norm over that of the internal forces."""
        force = self.film.force(self.displacement)
        left = force + 4.0 / self.step**2 * (self.film.mass @ (self.displacement[self.film.free] - known))
        return left, np.linalg.norm(left) / max(np.linalg.norm(force), 1e-300)

    def advance(self) -> None:
        """Take one step."""
        h, free = self.step, self.film.free
        begin = self.displacement[free]
        known = begin + h * self.velocity + 0.25 * h**2 * self.acceleration
        # First guess: the acceleration stays.
        self.displacement[free] = begin + h * self.velocity + 0.5 * h**2 * self.acceleration
        (left, before), first = self.residual(known), self.iterations
        while before > self.tolerance:
            if self.patience == 0 or self.factors is None:
                self.refresh()
            correction = self.factors.solve(left)
            self.displacement[free] -= correction
            self.iterations += 1
            self.age += 1
            left, after = self.residual(known)
            if self.iterations - first > MOST:
                raise RuntimeError(f"no convergence within {MOST} iterations of a step")
            if self.patience and after > self.tolerance:
                needed = np.log(after / self.tolerance) / np.log(before / after) if after < before else np.inf
                if needed > self.patience:
                    if after >= before and self.age > 1:
                        self.displacement[free] += correction
                    self.refresh()
                    left, after = self.residual(known)
            before = after
        self.velocity += 0.5 * h * self.acceleration
        self.acceleration = 4.0 / h**2 * (self.displacement[free] - known)
        self.velocity += 0.5 * h * self.acceleration


def run(problem, patience):
    """Record of the probe and what it cost."""
    began = time.process_time()
    film = Film(problem)
    stepper = Stepper(film, problem, patience)
    count, probe = int(problem["count"]), film.unknowns[int(problem["probe"])]
    record, clock = np.zeros((count + 1, 3)), np.zeros((count + 1, 2))
    ready = time.process_time()
    for number in range(1, count + 1):
        stepper.advance()
        record[number] = stepper.displacement[probe]
        clock[number] = number, time.process_time() - ready
    kept = f"factors kept while they serve ({patience})" if patience else "Newton"
    return film_result(
        record,
        clock,
        ready - began,
        version=skfem.__version__,
        solver=f"SuperLU, {kept}",
        iterations=stepper.iterations,
        factorizations=stepper.factorizations,
    )


if __name__ == "__main__":
    np.savez(sys.argv[2], **run(dict(np.load(sys.argv[1])), int(sys.argv[3])))
