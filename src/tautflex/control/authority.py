"""What each input can do to each mode: stiffness that it changes, force that it puts on it [control.md 1]."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.control.columns import InputColumns, by_name, columns_of, loads_of, stiffness_changes, without_round_off
from tautflex.control.steady import steady_state
from tautflex.errors import InputError
from tautflex.mechanics.system import StructuralSystem
from tautflex.motion.kinematics import RigidMotion
from tautflex.numeric import Array, within_arithmetic
from tautflex.reduction.on_basis import OnBasis
from tautflex.solvers.linear.eigenpairs import lowest_eigenpairs
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.variables import AUTHORITY, described

# Strokes below this are hard for drives [m].
_SHORT = 1e-5
# A change of the stiffness that is worth a law.
_NOTABLE = 0.01


@within_arithmetic()
def authority(
    plant: PrestressedState | OnBasis,
    inputs: Mapping[str, Any],
    *,
    limits: Mapping[str, ArrayLike] | None = None,
    motion: RigidMotion | None = None,
    values: Mapping[str, ArrayLike] | None = None,
    modes: int = 10,
) -> xr.Dataset:
    """What each input at its limit can do to the lowest modes, whose supports stand still or move steadily.

    Parameters
    ----------
    plant
        Prestressed state or reduced model, whose structure is looked at.
    inputs
        Name -> input, as in `linearize`.
    limits
        Name -> largest size of its numbers, one for all or one each; those left out have 1.
    motion, values
        Steady motion, and inputs that are held, as in `linearize`.
    modes
        Number of modes.

    Returns
    -------
    xarray.Dataset
        Over (input, mode): ``stiffness``, relative change of the mode's stiffness by the limit, the structure's static
        answer included; ``force`` on the mass-normalised mode [N/kg^1/2]; ``deflection``, the largest static
        displacement of the mode by that force [m]. ``stroke(input)``: length that the drives of cables reel in for it
        [m]; ``frequency(mode)`` [Hz], ``limit(input)``. ``attrs["remarks"]`` says in words what a law cannot do.

    Raises
    ------
    InputError
        If an argument is wrong, an input has no linear form, or none acts on the structure.
    UnsupportedError
        If the structure can drift away.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> pull = tf.TensionGroup("y", command="tension")
    >>> state = tf.equip(state, [pull])
    >>> able = tf.authority(state, {"pull": pull}, limits={"pull": 0.3}, modes=3)
    >>> able.sizes["mode"]
    3
    """
    state = plant.state if isinstance(plant, OnBasis) else plant
    checks.instance("plant", state, PrestressedState, "a prestressed state or a reduced model")
    effects = columns_of(inputs, state.system)
    if not effects:
        text = "inputs: expected at least one that acts on the structure, got none"
        raise InputError(
            f"{text}; torques on a hub act on no mode of a structure that it holds, `linearize` tells theirs"
        )
    largest_inputs = by_name("limits", limits, effects)
    about = steady_state(state, effects, values, None, motion, None)
    system = about.state.system
    count = min(checks.whole("modes", modes, 1), system.size)
    squares, vectors = lowest_eigenpairs(system.pattern, about.stiffness, system.inertia.mass_entries, count)
    largest = np.abs(system.translations(vectors)).reshape(count, -1).max(axis=1)
    parts, remarks = dict[str, list[Array]](), list[str]()
    for effect in effects:
        size = largest_inputs.get(effect.name, np.ones(effect.count))
        loads = loads_of(effect, system, about.q)
        answers = about.solve(loads)
        change = stiffness_changes(effect, system, about.q, answers, vectors, about.films)
        stiffness = size[:, None] * np.einsum("kii->ki", change) / squares
        force = size[:, None] * without_round_off(vectors, loads).T
        stroke = _reeled(effect, system, answers, size)
        deflection = force / squares * largest
        for name, part in (("stiffness", stiffness), ("force", force), ("deflection", deflection)):
            parts.setdefault(name, []).append(part)
        parts.setdefault("stroke", []).append(stroke)
        parts.setdefault("limit", []).append(size)
        remarks += [
            text for k in range(effect.count) if (text := _remark(effect, k, force[k], stiffness[k], float(stroke[k])))
        ]
    data = {name: np.concatenate(part) for name, part in parts.items()}
    data["frequency"] = np.sign(squares) * np.sqrt(np.abs(squares)) / (2.0 * np.pi)
    labels = [label for effect in effects for label in effect.labels]
    return xr.Dataset(
        described(AUTHORITY, data),
        coords={"input": labels, "mode": np.arange(1, count + 1)},
        attrs={"title": "what each input at its limit does to each mode", "remarks": "\n".join(remarks)},
    )


def _reeled(given: InputColumns, system: StructuralSystem, answers: Array, size: Array) -> Array:
    """Longest length of a cable that is reeled in for each number at its size [m], NaN without cables, shape (n,)."""
    longest = np.full(given.count, np.nan)
    for k in range(given.count):
        if given.stroke is not None:
            longest[k] = np.abs(given.stroke(size[k] * answers[:, k], float(size[k]))).max()
            continue
        for index in system.block_index("cable"):
            if index in given.columns:
                block = system.blocks[index]
                reel = given.columns[index][:, 0, k] / block.elasticity[:, 0, 0] * block.measure / block.size
                longest[k] = np.fmax(longest[k], size[k] * np.abs(reel).max(initial=0.0))
    return longest


def _remark(effect: InputColumns, number: int, force: Array, stiffness: Array, stroke: float) -> str:
    """What a law cannot do with an input; empty where there is nothing to say."""
    label, told = effect.labels[number], []
    if not force.any():
        told.append(
            "no linear column on these modes: it changes their stiffness instead, which LQR and LQG cannot use"
            if effect.columns
            else "no force on these modes"
        )
    if effect.columns and np.abs(stiffness).max(initial=0.0) < _NOTABLE:
        told.append(f"it changes their stiffness by {100.0 * np.abs(stiffness).max(initial=0.0):.2g} % at most")
    if stroke < _SHORT:
        told.append(f"its drives reel {1e6 * stroke:.2g} micrometres: softer tendons make more of them")
    return f"{label}: {'; '.join(told)}" if told else ""
