"""How far the film is from a plane."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from tautflex.control.sensors.sensor import PreparedSensor, SensedMotion, Sensor
from tautflex.errors import InputError
from tautflex.mechanics.inertia import InertiaOperator
from tautflex.motion.hub import FreeHub
from tautflex.numeric import Array
from tautflex.solvers.static.prestress import PrestressedState


@dataclass(frozen=True)
class SurfaceRms(Sensor):
    """Root mean square over the film's area of its deflection along z from the best plane [m]; no instrument has it.

    The plane ``a + b x + c y`` is the one of least squares over the area, and integrals are those of the elements'
    own interpolation.
    """

    privileged: ClassVar[bool] = True

    def prepare(self, state: PrestressedState, hub: FreeHub | None = None) -> PreparedSensor:
        """``w'Ww - r'G^-1 r`` over the area, with r and G the moments (1, x, y) of the deflection and of the area."""
        system = state.system
        index = system.block_index("membrane")
        if not index:
            raise InputError("SurfaceRms: expected a model with a film, got none; add triangles to the model")
        # Inertia of a film that weighs 1 kg per square metre: its mass is its area.
        blocks = []
        for one in (system.blocks[k] for k in index):
            areal = one.material.density * one.elements_of(one.size, np.minimum)
            mass = one.inertia.mass / areal[:, None]
            blocks.append(replace(one, inertia=replace(one.inertia, mass=mass)))
        area = InertiaOperator.from_blocks(blocks, [system.place[one.dofs] for one in blocks], system.pattern)
        square = area.matrix(np.diag([0.0, 0.0, 1.0])).tocsr()
        moments = np.stack([area.zeroth_moment[2], area.first_moment[2, 0], area.first_moment[2, 1]])
        first = area.mass_moment[:2]
        gram = np.block([[np.array([[area.mass]]), first[None]], [first[:, None], area.second_moment[:2, :2]]])
        plane = np.linalg.inv(gram)

        def rms(motion: SensedMotion) -> Array:
            tilt = moments @ motion.q
            rest = motion.q @ (square @ motion.q) - tilt @ plane @ tilt
            return np.array([np.sqrt(max(float(rest), 0.0) / area.mass)])

        return PreparedSensor("m", 1, None, rms)
