r"""Linear view of a structure on its hub, about a steady state [control.md 2, 3].

In coordinates ``q = Phi' eta``, with r the accelerations of the hub in its free directions, small motion is

    [[R, L Phi'], [Phi L', M]] (r, eta'') + [[0, -2 w c'], [2 w c, C + G]] (omega, eta') + (0, K eta) = (W, Phi F) u,

where w is the spin of a hub of one axis and c what its square pulls at. Translations of a free hub have no stiffness
and nothing looks at them: they are eliminated by momentum, exactly. Modes that are left out follow at once,

    q_s = (K^-1 - Phi' (Phi K Phi')^-1 Phi) (F u - L' r - 2 w c omega),

which is the static correction [Hansteen & Bell 1979, Earthq. Eng. Struct. Dyn. 7]: part of C and D.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import block_diag

from tautflex import checks
from tautflex.control.columns import (
    InputColumns,
    columns_of,
    loads_of,
    rigid_rows,
    stiffness_changes,
    without_round_off,
)
from tautflex.control.linear import LinearPlant
from tautflex.control.sensors.sensor import PreparedSensor, SensedMotion, Sensor, SensorRows
from tautflex.control.signals import Channel
from tautflex.control.steady import SteadyState, steady_state
from tautflex.errors import InputError
from tautflex.mechanics.dampings.damping import Damping
from tautflex.mechanics.dampings.rayleigh import Rayleigh
from tautflex.motion.coupling import Coupling
from tautflex.motion.hub import FreeHub
from tautflex.motion.kinematics import RigidMotion
from tautflex.numeric import Array, one_thread, within_arithmetic
from tautflex.reduction.on_basis import OnBasis
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.text import shown

_MODES = 60
# Parts of a column below this are round-off.
_ROUND_OFF = 1e-11


@within_arithmetic()
def linearize(
    plant: PrestressedState | OnBasis,
    inputs: Mapping[str, Any],
    sensors: Mapping[str, Sensor],
    *,
    hub: FreeHub | None = None,
    damping: Damping | None = None,
    motion: RigidMotion | None = None,
    values: Mapping[str, ArrayLike] | None = None,
    coupling: Coupling | None = None,
    modes: int = _MODES,
) -> LinearPlant:
    """Linear view of small motion about a steady state.

    Parameters
    ----------
    plant
        Prestressed state, whose lowest modes are the coordinates, with the static correction of the others; or a
        reduced model, whose coordinates they are.
    inputs
        Name -> input, such as ``tf.NodalForce(...)``, or its wrench on the hub, force and torque about
        the origin per number, shape (6, n) [N, N m].
    sensors
        Name -> sensor.
    hub
        Hub that is free; None: its motion is prescribed.
    damping
        `Rayleigh`, `Modal` or any other `Damping`; None is none.
    motion
        Steady motion of a prescribed hub (``maneuver.start()``); None is rest. A free hub of one axis has its own.
    values
        Name of an input -> numbers that are held in the steady state, such as a tension; those left out are 0.
    coupling
        Switches of the rotating-frame terms of a prescribed motion.
    modes
        Number of the lowest modes of a prestressed state.

    Returns
    -------
    LinearPlant

    Raises
    ------
    InputError
        If an argument is wrong, or an input has no linear form.
    UnsupportedError
        If the structure can drift away, or a hub spins about free axes.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> import numpy as np
    >>> hub = tf.FreeHub(mass=50.0, inertia=(5.0, 5.0, 8.0), axes="x")
    >>> sensors = {"attitude": tf.Attitude(), "rate": tf.Rate()}
    >>> plant = tf.linearize(state, {"torque": np.eye(6)[:, 3:4]}, sensors, hub=hub, modes=4)
    >>> plant.A.shape, plant.inputs, plant.outputs
    ((10, 10), ('torque',), ('attitude', 'rate'))
    """
    state = plant.state if isinstance(plant, OnBasis) else plant
    checks.instance("plant", state, PrestressedState, "a prestressed state or a reduced model")
    checks.instance("hub", hub, (FreeHub, type(None)), "a FreeHub(...), or None")
    damping = Rayleigh() if damping is None else damping
    checks.instance("damping", damping, Damping, "an object such as Rayleigh(0.001, 0.001)")
    checks.whole("modes", modes, 1)
    effects = columns_of(inputs, state.system)
    if not isinstance(sensors, Mapping):
        raise InputError(f"sensors: expected a mapping such as {{'rate': Rate()}}, got {shown(sensors)}; name them")
    for name, sensor in sensors.items():
        checks.instance(f"sensors.{name}", sensor, Sensor, "a sensor such as Rate()")
    with one_thread():
        about = steady_state(state, effects, values, hub, motion, coupling)
        bound = {name: sensor.prepare(state, hub) for name, sensor in sensors.items()}
        return _View(about, plant, effects, modes).plant(bound, damping)


class _View:
    """Matrices of one steady state."""

    def __init__(self, about: SteadyState, plant: PrestressedState | OnBasis, effects: list[InputColumns], modes: int):
        self.about, self.effects, system = about, effects, about.state.system
        self.reduced = isinstance(plant, OnBasis)
        self.labels = [label for effect in effects for label in effect.labels]
        self.loads = np.concatenate(
            [np.zeros((system.size, 0)), *(loads_of(effect, system, about.q) for effect in effects)], axis=1
        )
        self.answers = about.solve(self.loads)
        if isinstance(plant, OnBasis):
            kept, derivatives = plant.basis.kept, plant.basis.derivatives
            reach = self._condensed(kept, derivatives)
            self.vectors, self.fast = reach, derivatives
        else:
            self.vectors = about.modes(min(modes, system.size))
            self.fast = np.zeros((0, system.size))
        self.mass = self._projected(system.inertia.mass_entries)
        self.stiffness = self._projected(about.stiffness)

    def _projected(self, entries: Array) -> Array:
        result = self.vectors @ self.about.product(entries, self.vectors).T
        return 0.5 * (result + result.T)

    def _condensed(self, kept: Array, derivatives: Array) -> Array:
        """Kept vectors with the static derivatives that follow them."""
        if not len(derivatives):
            return kept
        moved = self.about.product(self.about.stiffness, derivatives)
        return np.asarray(kept - (np.linalg.solve(moved @ derivatives.T, moved @ kept.T)).T @ derivatives)

    def rest(self, loads: Array, whole: Array | None = None) -> Array:
        """Answer to loads (size, n) beside that of the coordinates; ``whole`` is the whole one where it is known."""
        if self.reduced and whole is None:
            fast = self.fast
            if not len(fast):
                return np.zeros_like(loads)
            stiffness = self.about.product(self.about.stiffness, fast) @ fast.T
            return np.asarray(fast.T @ np.linalg.solve(stiffness, fast @ loads))
        answer = self.about.solve(loads) if whole is None else whole
        return np.asarray(answer - self.vectors.T @ np.linalg.solve(self.stiffness, self.vectors @ loads))

    def plant(self, sensors: Mapping[str, PreparedSensor], damping: Damping) -> LinearPlant:
        """The linear plant."""
        about, r = self.about, len(self.vectors)
        d, h, size = len(about.directions), about.axes, about.state.system.size
        hub_mass, link = about.blocks if d else (np.zeros((0, 0)), np.zeros((0, size)))
        coupled = self.vectors @ link.T
        pushes = without_round_off(self.vectors, self.loads)
        rows = rigid_rows(about.state.system, about.q)
        wrench = np.concatenate([np.zeros((6, 0)), *(one.wrench(rows, about.q) for one in self.effects)], axis=1)
        swing = 2.0 * about.spin * about.swing if about.spin else np.zeros(size)
        rates = block_diag(np.zeros((d, d)), self._damping(damping))
        if about.spin:
            rates[0, d:], rates[d:, 0] = -self.vectors @ swing, self.vectors @ swing
        mass = np.block([[hub_mass, coupled.T], [coupled, self.mass]])
        inverse = np.linalg.inv(mass)
        back = inverse @ block_diag(np.zeros((d, d)), self.stiffness)
        given = inverse @ np.concatenate([wrench[about.directions], pushes])
        drag = inverse @ rates
        # Translations have no place among the states: nothing depends on them.
        turns = np.concatenate([np.arange(h), d + np.arange(r)])
        moving = np.concatenate([-back[:, turns], -drag[:, turns]], axis=1)
        n = h + r
        a = np.block([[np.zeros((n, n)), np.eye(n)], [moving[turns]]])
        # In units of the same energy, what is left of a column by symmetry is round-off.
        sizes = np.abs(given[turns]) * np.sqrt(mass.diagonal())[turns, None]
        pushed = np.where(sizes > _ROUND_OFF * sizes.max(axis=0, initial=0.0), given[turns], 0.0)
        b = np.concatenate([np.zeros((n, len(self.labels))), pushed])
        # What follows at once, from the state and from the inputs.
        own = self._rest_of_inputs()
        by_hub = self.rest(np.concatenate([link.T, swing[:, None]], axis=1)) if d else np.zeros((size, 1))
        from_state = -by_hub[:, :d] @ moving[:d]
        if about.spin:
            from_state[:, n] -= by_hub[:, d]
        from_inputs = own - by_hub[:, :d] @ given[:d]
        shapes = np.concatenate([np.zeros((size, h)), self.vectors.T, np.zeros((size, n))], axis=1) + from_state
        speeds = np.concatenate([np.zeros((size, n + h)), self.vectors.T], axis=1)
        outputs, units, c, through, level, remarks = self._seen(sensors, shapes, speeds, from_inputs)
        letters = "xyz"
        axes = [letters[k - 3] for k in about.directions[:h]]
        coordinates = [f"eta{k + 1}" for k in range(r)]
        positions = [*(f"theta_{axis}" for axis in axes), *coordinates]
        bilinear = self.bilinear
        return LinearPlant(
            a, b, c, through,
            (*positions, *(f"omega_{axis}" for axis in axes), *(f"d_{name}" for name in coordinates)),
            tuple(self.labels), outputs,
            tuple(unit for effect in self.effects for unit in effect.units), units,
            h, self.stiffness, bilinear, level, self._remarks(b, bilinear) | remarks,
        )  # fmt: skip

    @property
    def bilinear(self) -> Array:
        """Khat of all inputs, shape (input, r, r)."""
        about, first, parts = self.about, 0, [np.zeros((0, len(self.vectors), len(self.vectors)))]
        for effect in self.effects:
            own = self.answers[:, first : first + effect.count]
            parts.append(stiffness_changes(effect, about.state.system, about.q, own, self.vectors, about.films))
            first += effect.count
        return np.concatenate(parts)

    def _rest_of_inputs(self) -> Array:
        """Answers to the inputs beside the coordinates; a reduced model takes those to stresses whole."""
        result, first = np.zeros_like(self.loads), 0
        for effect in self.effects:
            part = slice(first, first + effect.count)
            whole = None if self.reduced and not effect.columns else self.answers[:, part]
            result[:, part] = self.rest(self.loads[:, part], whole)
            first += effect.count
        return result

    def _damping(self, damping: Damping) -> Array:
        """``Phi (C + G) Phi'``, shape (r, r)."""
        state, vectors = self.about.state, self.vectors
        linear = self.about.reference.linear
        matrix = damping.of(linear)
        viscous = self._projected(linear.entries(matrix)) + vectors @ matrix.low_rank_force(vectors.T)
        weight = self.about.coupling.velocity_weight(self.about.motion)
        if not weight.any():
            return np.asarray(viscous)
        return np.asarray(viscous + vectors @ (state.system.inertia.matrix(weight) @ vectors.T))

    def _seen(
        self, sensors: Mapping[str, PreparedSensor], shapes: Array, speeds: Array, from_inputs: Array
    ) -> tuple[tuple[str, ...], tuple[str, ...], Array, Array, Array, dict[str, str]]:
        """Labels, units, C, D and level of the outputs, and words on sensors that have no row."""
        about, h, n = self.about, self.about.axes, shapes.shape[1] // 2
        axes = np.eye(3)[[k - 3 for k in about.directions[:h]]].reshape(h, 3)
        still = SensedMotion(
            about.q,
            np.zeros_like(about.q),
            np.zeros(3),
            about.motion.angular_velocity,
            about.state.system.stress(about.q),
        )
        labels, units, levels, remarks = list[str](), list[str](), list[Array](), dict[str, str]()
        c, through = [np.zeros((0, 2 * n))], [np.zeros((0, len(self.labels)))]
        for name, sensor in sensors.items():
            if sensor.rows is None:
                remarks[name] = "a row of zeros: its reading is not linear in the motion; linear laws cannot use it"
            rows, own = sensor.rows or SensorRows(), np.zeros((sensor.size, 2 * n))
            looked, direct = self._looked(rows, sensor.size)
            own += looked @ shapes
            if rows.velocity is not None:
                own += rows.velocity @ speeds
            if rows.rotation is not None:
                own[:, :h] += rows.rotation @ axes.T
            if rows.rate is not None:
                own[:, n : n + h] += rows.rate @ axes.T
            c.append(own)
            through.append(looked @ from_inputs + direct)
            labels += Channel(name, sensor.unit, sensor.size).labels
            units += [sensor.unit] * sensor.size
            levels.append(sensor.read(still))
        return (
            tuple(labels),
            tuple(units),
            np.concatenate(c),
            np.concatenate(through),
            np.concatenate([np.zeros(0), *levels]),
            remarks,
        )

    def _looked(self, rows: SensorRows, count: int) -> tuple[Array, Array]:
        """Rows on the free unknowns, those of stresses included, and what inputs that are stresses add at once."""
        system, q = self.about.state.system, np.append(self.about.q, 0.0)
        look, direct = np.zeros((count, system.size + 1)), np.zeros((count, len(self.labels)))
        if rows.displacement is not None:
            look[:, :-1] += rows.displacement.toarray() if hasattr(rows.displacement, "toarray") else rows.displacement
        for index, weights in rows.stress.items():
            block, places = system.blocks[index], system.row_places[index]
            on_strain = np.einsum("prs,rst->prt", weights, block.elasticity)
            on_unknowns = np.einsum("prt,rtd->prd", on_strain, block.strain_slope(q[places]))
            for row in range(count):
                np.add.at(look[row], places, on_unknowns[row])
            first = 0
            for effect in self.effects:
                if index in effect.columns:
                    direct[:, first : first + effect.count] += np.einsum("prs,rsk->pk", weights, effect.columns[index])
                first += effect.count
        return look[:, :-1], direct

    def _remarks(self, b: Array, bilinear: Array) -> dict[str, str]:
        """Why an input has no column, or one on a part of the coordinates alone."""
        found, r = dict[str, str](), len(self.vectors)
        lowest = float(self.stiffness[0, 0])
        pushed = np.abs(without_round_off(self.vectors, self.loads)) > 0.0
        numbers = [(effect, k) for effect in self.effects for k in range(effect.count)]
        for place, (effect, _) in enumerate(numbers):
            label, moves = self.labels[place], int(pushed[:, place].sum())
            change = float(bilinear[place, 0, 0]) / lowest
            stiffens = f"it changes the stiffness instead ({100.0 * change:.3g} % of the lowest coordinate's per unit)"
            if effect.columns and not np.any(b[:, place]):
                found[label] = f"no linear column: {stiffens}; use TensionDamping or StiffnessSwitching"
            elif effect.columns and moves < r:
                found[label] = f"linear column on {moves} of {r} coordinates alone, those in the plane: {stiffens}"
            elif not np.any(b[:, place]):
                found[label] = "no linear column: it acts on supported directions alone, whose motion is prescribed"
        return found
