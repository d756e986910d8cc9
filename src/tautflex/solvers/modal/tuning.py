"""Cable tensions that put chosen natural frequencies on target [theory.md 5]."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tautflex import checks
from tautflex.errors import InputError, NotConvergedError
from tautflex.numeric import Array
from tautflex.solvers.modal.natural import Modes, solve_modes
from tautflex.solvers.modal.refinement import mesh_errors
from tautflex.solvers.plausibility import doubts_about_structure
from tautflex.solvers.static.prestress import PrestressedState, prestressed
from tautflex.structure.model import Model
from tautflex.structure.shapes import TRIANGLE3
from tautflex.text import brief

# Modes that are looked at, without and with half-waves to be found among those of flapping edges.
_FEW, _MANY = 10, 40
# Likeness to sines below which a mode is hardly the one meant; how much more an edge moves that flaps.
_ALIKE, _FLAPPING = 0.5, 2.0


@dataclass(frozen=True)
class TuneResult:
    """Tuned tensions.

    Parameters
    ----------
    scale_x, scale_y
        Factors on the prestress along x and y.
    frequencies
        First natural frequencies of the tuned structure [Hz].
    state
        The tuned prestressed state.
    modes
        Number of each tuned mode, from 1.
    mesh_errors
        Relative error that the mesh leaves in each tuned frequency, from quadratic triangles on the same corners; NaN
        where the film has other elements than linear triangles.
    warnings
        What the user should know, in words.
    """

    scale_x: float
    scale_y: float
    frequencies: Array
    state: PrestressedState
    modes: tuple[int, ...]
    mesh_errors: Array
    warnings: tuple[str, ...]

    __repr__ = brief


class _Trial(NamedTuple):
    """Modes under scaled tensions, and the places (from 0) of those with a target."""

    scale: Array
    modes: Modes
    places: list[int]


def tune_pretension(
    model: Model,
    frequencies: Sequence[float],
    modes: Sequence[int | tuple[int, int]] | None = None,
    tolerance: float = 1e-9,
    max_iterations: int = 30,
) -> TuneResult:
    """Scale the prestress until chosen natural frequencies hit their targets.

    Parameters
    ----------
    model
        Structure with a first guess of its tensions.
    frequencies
        One target scales x and y together; two targets scale them separately [Hz], > 0.
    modes
        Mode of each target: its number from 1, or its half-waves (m, n) along x and y, which are followed by the
        film's likeness to a product of sines wherever free edges flap below them; default 1, then 2.
    tolerance
        Allowed relative error of the frequencies.
    max_iterations
        Allowed Newton steps.

    Returns
    -------
    TuneResult

    Raises
    ------
    InputError
        If the targets are not one or two positive frequencies, or modes do not match them.
    NotConvergedError
        If no tensions reach the targets.

    Notes
    -----
    Squared frequencies are nearly linear in the tensions, so Newton's method in the logarithms of frequency squared
    and scale, with a difference Jacobian, needs a few steps.

    Examples
    --------
    >>> import tautflex as tf
    >>> found = tf.tune_pretension(tf.build_model(tf.load_case("m2.toml")), [1.5])
    >>> round(float(found.frequencies[0]), 6)
    1.5
    """
    checks.instance("model", model, Model, "a Model", remedy="build_model(case) and Model.from_mesh(...) give one")
    targets = checks.float_array("frequencies", frequencies, (None,))
    if targets.size not in (1, 2):
        raise InputError(f"frequencies: expected one or two targets, got {targets.size}")
    for target in targets.tolist():
        checks.positive("frequencies", target)
    checks.positive("tolerance", tolerance)
    checks.whole("max_iterations", max_iterations, 1)
    given = range(1, targets.size + 1) if modes is None else checks.several("modes", modes, (int, tuple), "1")
    wanted = list(given)
    numbers = [checks.whole("modes", least, 0) for each in wanted for least in np.ravel(each).tolist()]
    if len(wanted) != targets.size or min(numbers) < 1 or len(set(wanted)) != len(wanted):
        raise InputError(
            f"modes: expected {targets.size} different mode number(s) from 1, or half-waves (m, n), got {wanted}"
        )
    doubts = doubts_about_structure(model)
    count = max(_FEW, *(_MANY if isinstance(each, tuple) else each for each in wanted))

    def evaluate(logs: Array) -> tuple[Array, _Trial]:
        scale = np.exp(np.broadcast_to(logs, 2))
        state = prestressed(model.with_pretension_scaled(*scale), True, doubts)
        found = solve_modes(state, min(count, state.system.size - 1))
        places = [int(likeness(found, given).argmax()) if isinstance(given, tuple) else given - 1 for given in wanted]
        if max(places) >= len(found.frequencies):
            known = len(found.frequencies)
            raise InputError(f"modes: expected mode numbers up to {known}, got {max(places) + 1}; refine the mesh")
        return 2.0 * np.log(found.frequencies[places] / targets), _Trial(scale, found, places)

    logs = np.zeros(targets.size)
    error, trial = evaluate(logs)
    for _ in range(max_iterations):
        if float(np.abs(error).max()) <= 2.0 * tolerance:
            return _result(trial, wanted)
        slopes = np.column_stack(
            [(evaluate(logs + 1e-4 * column)[0] - error) / 1e-4 for column in np.eye(targets.size)]
        )
        change = np.linalg.lstsq(slopes, -error, rcond=None)[0]
        logs, error, trial = _damped(evaluate, logs, np.clip(change, -2.0, 2.0), error)
    raise NotConvergedError(
        f"tune: frequencies {trial.modes.frequencies[trial.places].round(6).tolist()} Hz after {max_iterations} "
        f"steps, target {targets.tolist()} Hz; frame modes do not follow the tension: choose film modes or one target"
    )


def _damped(
    evaluate: Callable[[Array], tuple[Array, _Trial]], logs: Array, change: Array, error: Array
) -> tuple[Array, Array, _Trial]:
    """Halve the step until the error falls (modes may change places on the way)."""
    for _ in range(6):
        new_error, trial = evaluate(logs + change)
        if float(np.abs(new_error).max()) < float(np.abs(error).max()):
            break
        change = 0.5 * change
    return logs + change, new_error, trial


def _result(trial: _Trial, wanted: Sequence[int | tuple[int, int]]) -> TuneResult:
    found, warnings = trial.modes, []
    flapping = edge_share(found)
    for place, given in zip(trial.places, wanted, strict=True):
        own = likeness(found, given if isinstance(given, tuple) else (1, 1))
        name = f"mode {place + 1} at {found.frequencies[place]:.4g} Hz"
        if isinstance(given, tuple):
            if own[place] < _ALIKE:
                warnings.append(
                    f"{name} is the one most like {given} half-waves, but only by {own[place]:.0%}; give it more "
                    "cables, or choose the mode by its number"
                )
        elif flapping[place] > _FLAPPING:
            warnings.append(
                f"{name} moves the film's edge {flapping[place]:.1f} times as far as its inside: a free edge flaps; "
                f"most like (1, 1) half-waves is mode {int(own.argmax()) + 1}, which modes = [(1, 1)] follows"
            )
    return TuneResult(
        float(trial.scale[0]),
        float(trial.scale[1]),
        found.frequencies[:_FEW],
        found.state,
        tuple(place + 1 for place in trial.places),
        mesh_errors(found, trial.places),
        tuple(warnings),
    )


def likeness(modes: Modes, half_waves: tuple[int, int]) -> Array:
    """Cosine in [0, 1] between the film's transverse shapes and sin(m pi x/a) sin(n pi y/b), shape (mode,)."""
    film = np.unique(modes.state.model.triangles)
    if not film.size:
        raise InputError(f"modes: expected mode numbers of a structure without a film, got half-waves {half_waves}")
    places = modes.state.model.nodes[film, :2]
    share = (places - places.min(axis=0)) / np.ptp(places, axis=0)
    sines = np.prod(np.sin(np.pi * np.array(half_waves) * share), axis=1)
    shapes = modes.shapes[:, film]
    return np.abs(shapes[:, :, 2] @ sines) / np.linalg.norm(shapes, axis=(1, 2)) / np.linalg.norm(sines)


def edge_share(modes: Modes) -> Array:
    """Largest transverse displacement of the film's edge over that of its inside, shape (mode,); 0 without a film."""
    model = modes.state.model
    ends, count = np.unique(np.sort(TRIANGLE3.sides(model.triangles), axis=1), axis=0, return_counts=True)
    edge = np.unique(ends[count == 1])
    inside = np.setdiff1d(model.triangles, edge)
    if not inside.size:
        return np.zeros(len(modes.frequencies))
    across = np.abs(modes.shapes[:, :, 2])
    return across[:, edge].max(axis=1) / np.maximum(across[:, inside].max(axis=1), np.finfo(float).tiny)
