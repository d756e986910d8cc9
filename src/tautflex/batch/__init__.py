"""Many runs at once on JAX, differentiable in their parameters (extra ``batch``)."""

from __future__ import annotations

from tautflex.batch.library import jax as _jax  # first: says in one line what is missing
from tautflex.batch.runs import Batch

__all__ = ["Batch"]
