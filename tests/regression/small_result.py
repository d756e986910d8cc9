"""A small run with fields, for readers and writers of results."""

from __future__ import annotations

import io
import tempfile
from pathlib import Path

import h5py
import xarray as xr

import tautflex as tf
from verification.builders import antenna


def small_result() -> xr.Dataset:
    """Twenty steps of a stop maneuver of a coarse antenna, with two probes and three stored fields."""
    state = tf.solve_prestress(antenna((0.59, 1.0), (4, 2)))
    run = tf.simulate(
        state,
        tf.Stop(rate=0.3, duration=0.05),
        time_step=5e-3,
        end_time=0.1,
        probes={"A": (0.5, 0.25), "B": (0.0, 0.0)},
        fields=[0.0, 0.05, 0.1],
    )
    return run.data


def result_files() -> list[bytes]:
    """The small run as written, and once more in HDF5's oldest layout, whose metadata carry no checksums."""
    with tempfile.TemporaryDirectory() as folder:
        path = tf.save(small_result(), Path(folder, "run.nc"))
        return [path.read_bytes(), without_checksums(path)]


def without_checksums(path: Path) -> bytes:
    """Copy of a result file in which damage to metadata is not found by a checksum."""
    memory = io.BytesIO()
    with h5py.File(path) as source, h5py.File(memory, "w", libver="earliest") as target:
        target.attrs.update(source.attrs)
        for name, variable in source.items():
            copy = target.create_dataset(name, data=variable[()])
            hidden = ("DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME", "_Netcdf4Coordinates", "_Netcdf4Dimid")
            copy.attrs.update({key: value for key, value in variable.attrs.items() if key not in hidden})
            if variable.is_scale:
                copy.make_scale(variable.attrs["NAME"])
        for name, variable in source.items():
            for axis, dimension in enumerate(variable.dims):
                for scale in dimension.values():
                    target[name].dims[axis].attach_scale(target[scale.name])
    return memory.getvalue()
