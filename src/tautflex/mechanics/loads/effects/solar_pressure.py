"""Pressure of sunlight on the film."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.loads.effects.nodes import bound_forces, unit_vector
from tautflex.mechanics.loads.inputs import Effect
from tautflex.mechanics.loads.prepared import PatternLoad, PreparedInput
from tautflex.mechanics.loads.signals import Signal
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array
from tautflex.text import brief


@dataclass(frozen=True)
class SolarPressure(Effect):
    """Sunlight on the flat film: what it absorbs pushes along the light, what it reflects along the normal too.

    Per area ``P cos(a) [(1 - specular) s - 2 (specular cos(a) + diffuse / 3) n]`` with the direction s of the light and
    the normal n against it, a the angle between them [McInnes, Solar Sailing, 1999, 2.6]. Direction and area are those
    of the reference shape; the frame and what shades the film are left out.

    Parameters
    ----------
    direction
        Where the light goes, floating-frame axes, of any length; it stays there while the antenna turns.
    share
        Share of full sunlight, 0 to 1: a number, or a function of time such as an eclipse's; None where a plant
        commands it.
    pressure
        Of light that is absorbed [Pa]; 4.56e-6 at 1 au.
    specular, diffuse
        Shares of the light that are reflected like a mirror and in all directions.
    breaks
        Instants at which the function jumps [s].
    """

    direction: Sequence[float]
    share: Signal | None = 1.0
    pressure: float = 4.56e-6
    specular: float = 0.0
    diffuse: float = 0.0
    breaks: tuple[float, ...] = ()
    signal: ClassVar[str] = "share"
    __repr__ = brief

    def prepare(self, system: StructuralSystem) -> PreparedInput:
        """Bind to a system with a film; the force of an element is shared by its nodes as its area is."""
        light = unit_vector("direction", self.direction)
        checks.positive("pressure", self.pressure)
        for name in ("specular", "diffuse"):
            checks.between(name, getattr(self, name), 0.0, 1.0)
        if self.specular + self.diffuse > 1.0:
            raise InputError(
                f"diffuse: expected no more than 1 - specular = {1.0 - self.specular:g}, got {self.diffuse:g}; the "
                "rest of the light is absorbed"
            )
        model = system.model
        if not model.surfaces:
            raise InputError("SolarPressure: expected a model with a film, got none; add triangles to the model")
        force = np.zeros((model.dof_count, 1))
        for group in model.surfaces:
            points, weights = group.shape.product_rule
            along = group.shape.tangents(model.nodes[group.connectivity], points)
            areas = np.cross(along[:, :, 0], along[:, :, 1]) * weights[:, None]
            nodal = np.einsum("pi,npk->nik", group.shape.functions(points), self._force(light, areas))
            np.add.at(force[:, 0], model.translation_dofs[group.connectivity], nodal)
        pattern, held = bound_forces(system, force)
        return PatternLoad(self.share, "share", ("share",), 0.0, pattern, held)

    def _force(self, light: Array, areas: Array) -> Array:
        """Force of full sunlight on areas along their normals [m^2], shape (..., 3)."""
        size = np.linalg.norm(areas, axis=-1, keepdims=True)
        cosine = (areas @ light)[..., None] / size
        # Against the light, on whichever side it falls.
        normal = -np.sign(cosine) * areas / size
        bright = np.abs(cosine)
        pushed = (1.0 - self.specular) * light - 2.0 * (self.specular * bright + self.diffuse / 3.0) * normal
        return np.asarray(self.pressure * size * bright * pushed)
