r"""Cables that one drive pulls: at a commanded tension, or by a commanded length [control.md 1].

A drive with a tendon of stiffness k [N/m] pulls at a cable of length L. Both in series resist with ``1/k' = 1/k +
L/(EA)``: reeling in a length s at an elongation e of the cable's span makes the tension ``T0 + k' (e + s)``. So the
cable element gets the modulus ``k' L/A``, and the length acts as the stress ``k' s/A``. At a commanded tension T0 + u
the drive follows every elongation: the element's modulus vanishes, its stress is ``(T0 + u)/A`` whatever the strain,
and the drive reels ``s = u/k' - e``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple

import numpy as np

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.loads.effects.cables import by_block, cable_columns, chosen_cables, of_cables
from tautflex.mechanics.loads.inputs import Effect, require_equipped
from tautflex.mechanics.loads.prepared import StressChange
from tautflex.mechanics.loads.signals import Signal
from tautflex.mechanics.system import StructuralSystem
from tautflex.numeric import Array, Indices
from tautflex.structure.model import Model
from tautflex.text import brief

COMMANDS = ("tension", "length")
_ROUND_OFF = 1e-9


@dataclass(frozen=True)
class TensionGroup(Effect):
    """Cables that one drive pulls, by one number: a change of their tension, or a length that is reeled in.

    How much it can do depends on the tendon. A stiff cable whose length is commanded changes its tension at a
    fixed structure only: film and frame give way, and almost nothing is left. It changes the structure, see `equip`:
    cables of a commanded tension have no stiffness along themselves, a tendon is in series with its cable. Tensions
    and masses of the state stay. The cables must be elastic.

    Parameters
    ----------
    cables
        ``"x"``, ``"y"`` or ``"z"``: all that run mainly along this axis; or their numbers (order of ``model.cables``);
        None selects all.
    change
        Change from the prestressed state, positive pulls: of the tension [N], or the length [m] that is reeled in; a
        number or a function of time; None where a plant commands it.
    command
        ``"tension"``: the drive holds the tension, whatever the structure does; ``"length"``: it holds the length.
    stiffness
        Stiffness of the tendon between drive and cable [N/m]; None is no tendon.
    share
        Part of the change that each cable gets: ``"equal"``: all of it; ``"pretension"``: in proportion to its
        pretension, the largest all of it; or numbers, one per cable, not negative.
    breaks
        Instants at which the function jumps [s].

    Raises
    ------
    InputError
        If the command is unknown, or the stiffness not positive.

    Examples
    --------
    >>> import tautflex as tf
    >>> pull = tf.TensionGroup("y", tf.TimeTable([0.0, 0.05], [0.0, 0.2]), stiffness=2e3)
    >>> pull.command
    'tension'
    """

    cables: Sequence[int] | str | None = None
    change: Signal | None = None
    command: str = "tension"
    stiffness: float | None = None
    share: Sequence[float] | str = "equal"
    breaks: tuple[float, ...] = ()
    signal: ClassVar[str] = "change"
    __repr__ = brief

    def __post_init__(self) -> None:
        checks.one_of("command", self.command, COMMANDS)
        if self.stiffness is not None:
            checks.positive("stiffness", self.stiffness)
        if isinstance(self.share, str):
            checks.one_of("share", self.share, ("equal", "pretension"))

    def prepare(self, system: StructuralSystem) -> ReeledCables:
        """Bind to a system that is equipped for it, InputError if it is not."""
        require_equipped(self, system)
        chosen = self._chosen(system)
        stiffness, tension = self._stiffness(system)[chosen], _Cables.of(system).tension[chosen]
        share = self._share(tension)
        per_unit, unit, lowest = share * stiffness, "m", -np.inf
        if self.command == "tension":
            pulled = share > 0.0
            # Cables cannot push; the rest is round-off.
            least = float(np.min(tension[pulled] / share[pulled]))
            per_unit, unit, lowest = share, "N", -least - _ROUND_OFF * abs(least)
        columns = cable_columns(system, chosen, per_unit[:, None])
        known = self.change, "change", (f"{self.command} [{unit}]",), lowest, columns
        return ReeledCables(*known, system, self.command, chosen, share, stiffness)

    def equipped(self, system: StructuralSystem) -> StructuralSystem:
        """The structure with the tendons, and without the stiffness of cables whose tension is commanded."""
        if self.command == "length" and self.stiffness is None:
            return system
        chosen, cables = self._chosen(system), _Cables.of(system)
        wanted = cables.modulus.copy()
        wanted[chosen] = 0.0
        if self.command == "length":
            wanted[chosen] = (self._stiffness(system) * cables.length / cables.area)[chosen]
        if np.array_equal(wanted, cables.modulus):
            return system
        changed, blocks = by_block(system, wanted != cables.modulus), list(system.blocks)
        for index, modulus in by_block(system, wanted).items():
            if changed[index].any() and not blocks[index].is_elastic:
                text = f"cables: expected elastic cables under {type(self).__name__}, got law {blocks[index].law!r}"
                raise InputError(f"{text}; give them law = 'elastic', or command a length without a tendon")
            blocks[index] = replace(blocks[index], elasticity=modulus[:, None, None])
        return system.with_initial_stress(system.initial_stress, tuple(blocks))

    def _chosen(self, system: StructuralSystem) -> Indices:
        """The cables; InputError if two of them are pieces of one."""
        chosen = chosen_cables(type(self).__name__, system, self.cables)
        shared = _joined_alone(system.model, chosen)
        if shared.size:
            text = f"cables: expected cables of one element each, got two that alone meet at node {shared[0]}"
            raise InputError(f"{text}; choose one of the two, the drive pulls there")
        return chosen

    def _share(self, tension: Array) -> Array:
        """Part of the change that each cable gets, shape (c,)."""
        if isinstance(self.share, str):
            largest = tension.max()
            if self.share == "equal" or largest <= 0.0:
                return np.ones(len(tension))
            return np.maximum(tension, 0.0) / largest
        share = checks.float_array("share", self.share, (len(tension),))
        if share.min() < 0.0 or not share.any():
            raise InputError(f"share: expected numbers >= 0, one at least > 0, got {share.tolist()}; correct them")
        return share

    def _stiffness(self, system: StructuralSystem) -> Array:
        """Axial stiffness that a length of each cable meets [N/m], tendon and cable in series, shape (c,)."""
        cables = _Cables.of(system)
        stands = self.command == "length" and self.stiffness is None
        stiffness = (cables.modulus if stands else cables.young) * cables.area / cables.length
        if stands and not stiffness[self._chosen(system)].all():
            raise InputError(
                "cables: expected cables with a stiffness, got some whose tension another input commands; take them "
                "out of one of the two"
            )
        return stiffness if self.stiffness is None else stiffness * self.stiffness / (stiffness + self.stiffness)


@dataclass(frozen=True)
class ReeledCables(StressChange):
    """Cables of a drive, and what it does: see `TensionGroup`.

    ``share`` is the part of the change and ``stiffness`` that of tendon and cable [N/m] of each of the ``cables``.
    """

    system: StructuralSystem
    command: str
    cables: Indices
    share: Array
    stiffness: Array

    def stroke(self, q: Array, value: float) -> Array:
        """Length of each cable that is reeled in since the prestressed state [m], shape (c,).

        Parameters
        ----------
        q
            Free unknowns [m, rad], shape (size,).
        value
            Command [N], or [m].
        """
        if self.command == "length":
            return self.share * value
        system, extended = self.system, np.append(q, 0.0)
        strain = [np.zeros(0)] * len(system.blocks)
        for index in system.block_index("cable"):
            block = system.blocks[index]
            g = np.einsum("nij,nj->ni", block.gradient, extended[system.row_places[index]])
            strain[index] = g @ block.linear[0] + 0.5 * np.einsum("ni,ij,nj->n", g, block.quadratic[0], g)
        elongation = (of_cables(system, strain) * _Cables.of(system).length)[self.cables]
        return np.asarray(self.share * value / self.stiffness - elongation)


class _Cables(NamedTuple):
    """Area [m^2], length [m], tension [N], modulus as it stands and of the cable itself [Pa], shapes (c,)."""

    area: Array
    length: Array
    tension: Array
    modulus: Array
    young: Array

    @classmethod
    def of(cls, system: StructuralSystem) -> _Cables:
        """All cables of a system."""
        blocks = system.blocks
        area = of_cables(system, [block.size for block in blocks])
        return cls(
            area,
            of_cables(system, [block.measure for block in blocks]) / area,
            of_cables(system, [stress[:, 0] for stress in system.initial_stress]) * area,
            of_cables(system, [block.elasticity[:, 0, 0] for block in blocks]),
            of_cables(system, [np.full(len(block.dofs), block.material.youngs_modulus) for block in blocks]),
        )


def _joined_alone(model: Model, chosen: Indices) -> Indices:
    """Nodes where two of the chosen cables meet, and nothing else, not even a support."""
    ends, every = np.bincount(model.cables[chosen].ravel(), minlength=len(model.nodes)), np.zeros(len(model.nodes))
    for group in model.groups:
        every += np.bincount(group.connectivity.ravel(), minlength=len(model.nodes))
    every[[node for link in model.links for node in link.joined]] += 1
    every[[node for spring in model.springs for node in spring.joined]] += 1
    free = np.all(model.free_places[model.translation_dofs] < len(model.free_dofs), axis=1)
    return np.flatnonzero((ends == 2) & (every == 2) & free)
