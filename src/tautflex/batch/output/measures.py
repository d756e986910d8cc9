"""Measures of a response as differentiable functions of its record."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp

from tautflex import checks
from tautflex.batch.library import jax
from tautflex.batch.output.response import Response
from tautflex.errors import InputError

Array = jax.Array

_COMPONENTS = ("u", "v", "w")


def history(response: Response, probe: int = 0, component: str = "w") -> Array:
    """Displacement of one probe [m], shape (time,).

    Raises
    ------
    InputError
        If the record has no displacement, or the component is none of ``"u"``, ``"v"``, ``"w"``.
    """
    if response.displacement is None:
        raise InputError("response: expected a record with displacement, got none; store = ('displacement',)")
    checks.one_of("component", component, _COMPONENTS)
    return response.displacement[:, probe, _COMPONENTS.index(component)]


def peak(response: Response, probe: int = 0, component: str = "w", sharpness: float | None = None) -> Array:
    """Largest absolute displacement of a probe [m].

    Parameters
    ----------
    response
        Record of a run.
    probe, component
        What is measured.
    sharpness
        None: the maximum itself, whose derivative is that of the largest sample; a number p: the p-norm
        ``(mean |w|^p)^(1/p)``, smooth, below the maximum and close to it for p of 20 and more.
    """
    size = jnp.abs(history(response, probe, component))
    if sharpness is None:
        return jnp.max(size)
    largest = jax.lax.stop_gradient(jnp.max(size))
    return largest * jnp.mean((size / largest) ** sharpness) ** (1.0 / sharpness)


def _mean_after(values: Array, response: Response, after: Any) -> Array:
    start = response.maneuver_end if after is None else after
    # The share of each interval that counts, so that the mean has a derivative with respect to its start.
    step = response.time[1] - response.time[0]
    share = jnp.clip((response.time - start) / step + 0.5, 0.0, 1.0)
    return jnp.sum(share * values) / jnp.sum(share)


def residual_rms(response: Response, probe: int = 0, component: str = "w", after: Any = None) -> Array:
    """Root mean square displacement of a probe [m] after an instant [s]; None is the end of the maneuver."""
    return jnp.sqrt(_mean_after(history(response, probe, component) ** 2, response, after))


def residual_energy(response: Response, after: Any = None) -> Array:
    """Mean energy of the elastic motion [J] after an instant [s]; None is the end of the maneuver.

    Raises
    ------
    InputError
        If the record has no energy.
    """
    return _mean_after(_energy(response), response, after)


def final_energy(response: Response) -> Array:
    """Kinetic and strain energy at the last instant [J]; InputError if the record has none."""
    return _energy(response)[-1]


def _energy(response: Response) -> Array:
    if response.energy is None:
        raise InputError("response: expected a record with energy, got none; store = ('energy',)")
    return response.energy.sum(axis=1)
