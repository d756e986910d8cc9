"""Single runs that a batch must reproduce: structures whose parameters were changed by hand."""

from __future__ import annotations

from dataclasses import replace

import tautflex as tf
from tautflex import ReducedModel
from tautflex.reduction.polynomial.projection import Moments, prestress_fields
from tautflex.reduction.polynomial.strains import HigherDegrees
from tautflex.solvers.static.prestress import PrestressedState

KINDS = ("membrane", "cable", "beam")


def factor(numbers: dict[str, float], name: str) -> float:
    return numbers.get(name, 1.0)


def changed_state(state: PrestressedState, numbers: dict[str, float]) -> PrestressedState:
    """State with tensions, moduli and densities multiplied, everything else as it was."""
    system = state.system
    fields = prestress_fields(state)
    x, y = factor(numbers, "tension_x"), factor(numbers, "tension_y")
    stress = [
        x * a + y * b + (x * y) ** 0.5 * c for a, b, c in zip(*(fields[k] for k in ("x", "y", "xy")), strict=True)
    ]
    blocks = tuple(
        replace(
            block,
            elasticity=block.elasticity * factor(numbers, f"youngs_modulus.{block.kind}"),
            inertia=replace(block.inertia, mass=block.inertia.mass * factor(numbers, f"density.{block.kind}")),
        )
        for block in system.blocks
    )
    twin = system.with_initial_stress(stress, blocks)
    reference, _ = twin.force(0.0 * state.reference_force)
    return PrestressedState(twin, reference, state.residual, state.relative_residual, 0)


def changed_rom(rom: ReducedModel, numbers: dict[str, float]) -> ReducedModel:
    """Reduced model on the same basis with other parameters."""
    projection, young = rom.projection, {kind: factor(numbers, f"youngs_modulus.{kind}") for kind in KINDS}
    x, y = factor(numbers, "tension_x"), factor(numbers, "tension_y")
    tension = {"x": x, "y": y, "xy": (x * y) ** 0.5}
    inertia = {}
    for kind, part in projection.inertia.items():
        rho = factor(numbers, f"density.{kind}")
        inertia[kind] = Moments(rho * part.mass, rho * part.pair, rho * part.first, rho * part.zeroth)
    return replace(
        rom,
        projection=replace(
            projection,
            elastic={kind: young[kind] * part for kind, part in projection.elastic.items()},
            higher={
                kind: HigherDegrees(young[kind] * part.quadratic, young[kind] * part.cubic)
                for kind, part in projection.higher.items()
            },
            stress={name: tension[name] * part for name, part in projection.stress.items()},
            inertia=inertia,
        ),
    )


def stop_of(numbers: dict[str, float]) -> tf.Stop:
    return tf.Stop(numbers["maneuver.rate"], numbers["maneuver.duration"])


def damping_of(numbers: dict[str, float]) -> tf.Rayleigh:
    return tf.Rayleigh(numbers["damping.alpha"], numbers["damping.beta"])
