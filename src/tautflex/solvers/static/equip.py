"""A prestressed state with what its inputs and actuators bring along: tendons in series with cables."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tautflex import checks
from tautflex.errors import InputError, PrestressError
from tautflex.mechanics.loads.inputs import TimeInput
from tautflex.numeric import within_arithmetic
from tautflex.solvers.static.diagnosis import instability_text
from tautflex.solvers.static.pivots import count_falling
from tautflex.solvers.static.prestress import PrestressedState, require_state


@within_arithmetic()
def equip(state: PrestressedState, inputs: Sequence[TimeInput]) -> PrestressedState:
    """Fit a state with the structure that inputs or actuators need, before it is simulated, reduced or linearized.

    Tensions, stresses and masses stay as they are; stiffnesses change.

    Parameters
    ----------
    state
        Prestressed state.
    inputs
        Inputs in time, or effects of actuators.

    Returns
    -------
    PrestressedState
        The state itself where nothing is to be changed.

    Raises
    ------
    InputError
        If an input does not fit the structure, or two of them want it different.
    PrestressError
        If the state is stable without and unstable with them.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> tension = tf.TensionGroup("x", change=lambda t: 0.1 if t < 0.05 else 0.0, breaks=(0.05,))
    >>> run = tf.simulate(tf.equip(state, [tension]), inputs=[tension], method=tf.Bathe(), time_step=5e-3, end_time=0.1)
    >>> run.status.value
    'completed'
    """
    require_state(state)
    given, system = checks.several("inputs", inputs, TimeInput, "TensionGroup('x')"), state.system
    for item in given:
        system = item.equipped(system)
    for number, item in enumerate(given, 1):
        if item.equipped(system) is not system:
            text = f"inputs: expected one structure for all of them, got {type(item).__name__} number {number}"
            raise InputError(f"{text}, whose cables another one needs different; give each cable one tendon")
    if system is state.system:
        return state
    equipped = replace(state, system=system)
    unstable = count_falling(system, equipped.tangent_entries, np.zeros(system.size))
    if unstable > state.unstable_modes:
        raise PrestressError(f"inputs: {instability_text(state.model, unstable)}")
    return replace(equipped, unstable_modes=unstable)
