"""State that a run ended in, as a Dataset: one variable for each array that its next step depends on."""

from __future__ import annotations

import json

import numpy as np
import xarray as xr

from tautflex.numeric import Array
from tautflex.solvers.transient.restart.checkpoint import Checkpoint

GROUP = "final"
"""Name of the group of a file that holds it."""
_MOTION = {"displacement": "m, rad", "velocity": "m s-1, rad s-1", "hub": "1"}
_WORDS = "what steps leave for the next one"


def checkpoint_data(final: Checkpoint) -> xr.Dataset:
    """Dataset of a state."""
    arrays = {name: _variable(name, getattr(final, name), units) for name, units in _MOTION.items()}
    arrays |= {f"memory.{name}": _variable(name, array, "") for name, array in final.memory.items()}
    attributes = {
        "time": final.time,
        "structure": json.dumps(dict(final.structure)),
        "question": json.dumps(dict(final.question)),
    }
    return xr.Dataset(arrays, attrs=attributes)


def checkpoint_from(data: xr.Dataset) -> Checkpoint:
    """State from its Dataset."""
    memory = {
        str(name).removeprefix("memory."): variable.values
        for name, variable in data.data_vars.items()
        if str(name).startswith("memory.")
    }
    structure = {name: tuple(numbers) for name, numbers in json.loads(data.attrs["structure"]).items()}
    displacement, velocity, hub = (np.asarray(data[name].values) for name in _MOTION)
    question = json.loads(data.attrs["question"])
    return Checkpoint(float(data.attrs["time"]), displacement, velocity, hub, structure, question, memory)


def _variable(name: str, array: Array, units: str) -> tuple[tuple[str, ...], Array, dict[str, str]]:
    values = np.asarray(array)
    dims = tuple(f"{name}.{axis}" for axis in range(values.ndim))
    about = {"units": units} if units else {"long_name": _WORDS}
    return dims, values, about
