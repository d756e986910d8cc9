"""Records of a plant that goes on for long, one after the other."""

from __future__ import annotations

import numpy as np
import xarray as xr


def joined(parts: list[xr.Dataset]) -> xr.Dataset:
    """Records of a run that went on, one after the other."""
    if len(parts) == 1:
        return parts[0]
    last = parts[-1]
    times = {name: variable.dims for name, variable in last.variables.items() if "time" in variable.dims}
    whole = {
        name: (dims, np.concatenate([part[name].values for part in parts]), last[name].attrs)
        for name, dims in times.items()
    }
    said = dict.fromkeys(text for part in parts for text in part.attrs["warnings"])
    names = {name: value for name, value in whole.items() if name != "time"}
    return last.drop_dims("time").assign(names).assign_coords(time=whole["time"]).assign_attrs(warnings=list(said))
