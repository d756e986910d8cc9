"""Records of a plant that goes on for long, one after the other."""

from __future__ import annotations

import numpy as np
import xarray as xr


def joined(parts: list[xr.Dataset]) -> xr.Dataset:
    """Records of a run that went on, one after the other."""
    if len(parts) == 1:
        return parts[0]
    last, axes = parts[-1], ("time", "frame_time")
    times = {name: variable.dims for name, variable in last.variables.items() if {*axes} & {*variable.dims}}
    whole = {
        name: (dims, np.concatenate([part[name].values for part in parts]), last[name].attrs)
        for name, dims in times.items()
    }
    said = dict.fromkeys(text for part in parts for text in part.attrs["warnings"])
    names = {name: value for name, value in whole.items() if name not in axes}
    found = last.drop_dims(axes).assign(names).assign_coords({name: whole[name] for name in axes})
    return found.assign_attrs(warnings=list(said))
