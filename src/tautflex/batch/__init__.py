"""Many runs at once on JAX, differentiable in their parameters (extra ``batch``)."""

from __future__ import annotations

from tautflex.batch import library  # first: says in one line what is missing
from tautflex.batch.output.measures import final_energy, history, peak, residual_energy, residual_rms
from tautflex.batch.output.response import Response
from tautflex.batch.runs import Batch

__all__ = ["Batch", "Response", "final_energy", "history", "library", "peak", "residual_energy", "residual_rms"]
