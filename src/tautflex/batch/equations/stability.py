"""Whether the potential falls about the equilibria from which the runs of a batch start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import lax

from tautflex.batch.equations.equation import Equation
from tautflex.batch.equations.full import FullPlant
from tautflex.batch.equations.rate_history import Spin
from tautflex.batch.library import jax
from tautflex.batch.steps.products import one_by_one
from tautflex.errors import NotConvergedError
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import RigidMotion
from tautflex.solvers.static.equilibrium import spinning_equilibrium
from tautflex.solvers.static.pivots import find_fall
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.static.stability import stiffness_about

Array = jax.Array

# Of the largest eigenvalue: smaller ones are round-off.
_ROUND_OFF = 1e-12


def reduced_falls(equation: Equation, size: int, q: Array, spin: Spin) -> Array:
    """Rates [1/s] at which motion leaves equilibria in steady spin where nothing holds it back; 0: none, shape (runs,).

    The root of the lowest eigenvalue of the tangent on the coordinates, all of them, shape (size, runs).
    """
    q, spin = lax.stop_gradient((q, spin))

    def static(q: Array) -> Array:
        still = jnp.zeros_like(q)
        return equation.forces(q, still, spin, equation.predicted(q, still, spin)).total

    units = jnp.eye(size)[:, :, None] * jnp.ones(q.shape[1:])
    tangents = jax.vmap(lambda unit: jax.jvp(static, (q,), (unit,))[1])(units)
    masses = jax.vmap(equation.mass)(units)
    return one_by_one(_rate, jnp.moveaxis(tangents, -1, 0), lax.stop_gradient(jnp.moveaxis(masses, -1, 0)))


def _rate(stiffness: Array, mass: Array) -> Array:
    lower = jnp.linalg.cholesky(mass)
    half = jax.scipy.linalg.solve_triangular(lower, stiffness, lower=True)
    whole = jax.scipy.linalg.solve_triangular(lower, half.T, lower=True)
    values = jnp.linalg.eigvalsh(0.5 * (whole + whole.T))
    return jnp.where(values[0] < -_ROUND_OFF * jnp.max(jnp.abs(values)), jnp.sqrt(jnp.abs(values[0])), 0.0)


def full_fall(plant: FullPlant, row: Mapping[str, Any], motion: RigidMotion, coupling: Coupling) -> float:
    """The same for the full model with the parameters of a run [1/s]; NaN where there is no equilibrium."""
    state = _changed(plant, row)
    try:
        q = spinning_equilibrium(state, motion, coupling)
    except NotConvergedError:
        return float("nan")  # the run is labelled
    fall = find_fall(state.system, stiffness_about(state, q, motion, coupling), q)
    return 0.0 if fall is None else float(np.sqrt(-fall.eigenvalue))


def instability_text(falls: np.ndarray) -> list[str]:
    """Sentence about runs that start from unstable equilibria, from their rates [1/s], shape (run,)."""
    unstable = np.flatnonzero(falls > 0.0)
    if not unstable.size:
        return []
    worst = int(unstable[falls[unstable].argmax()])
    return [
        f"{unstable.size} of {len(falls)} runs start from an unstable equilibrium; motion leaves that of run {worst} "
        f"at {falls[worst]:.3g} 1/s, where neither damping nor Coriolis forces hold it back: raise the tension or spin "
        "more slowly; simulate with the numbers of that run tells where it grows"
    ]


def _changed(plant: FullPlant, row: Mapping[str, Any]) -> PrestressedState:
    """The state with its tensions, moduli and densities multiplied."""
    x, y = row.get("tension_x", 1.0), row.get("tension_y", 1.0)
    tension = {"x": x, "y": y, "xy": np.sqrt(x * y)}
    system, blocks = plant.state.system, []
    for block in system.blocks:
        young, density = (row.get(f"{name}.{block.kind}", 1.0) for name in ("youngs_modulus", "density"))
        inertia = replace(block.inertia, mass=density * block.inertia.mass)
        blocks.append(replace(block, elasticity=young * block.elasticity, inertia=inertia))
    stress = [
        sum((tension[name] * part for name, part in fields.items()), np.zeros(block.elasticity.shape[:2]))
        for block, fields in zip(blocks, plant.stresses, strict=True)
    ]
    twin = system.with_initial_stress(stress, tuple(blocks))
    return replace(plant.state, system=twin, reference_force=twin.force(np.zeros(twin.size))[0])
