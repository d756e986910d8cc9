"""Film of a run: the structure as it turns and rings, and the record of the liveliest probe with the time in it."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.animation import FFMpegWriter, HTMLWriter, PillowWriter
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from tautflex import checks
from tautflex.analysis.turning import recorded_attitude
from tautflex.errors import InputError, MissingExtraError
from tautflex.motion.rotations import matrix
from tautflex.numeric import Array
from tautflex.plot.shapes import drawn_factor
from tautflex.plot.style import DIVERGING, length_unit, new_figure, styled, thinned
from tautflex.plot.surface import VIEW, draw_surface, wireframe
from tautflex.solvers.transient.status import Run
from tautflex.solvers.variables import RUN, dataset_of
from tautflex.writing import written_together

_FORMATS = {".gif": PillowWriter, ".mp4": FFMpegWriter, ".html": HTMLWriter}
_MOST = 300


@styled
def animate(
    run: xr.Dataset | Run,
    path: str | os.PathLike[str],
    *,
    magnification: float | None = None,
    turning: bool = True,
    frames: int = 100,
    rate: float = 20.0,
    dots: int = 110,
) -> Path:
    """Write a film of the deflected structure from the stored fields of a run.

    Parameters
    ----------
    run
        A run, or its Dataset, with the mesh and ``displacement(field_time, node, component)`` or, where there are more
        of them, ``frame_displacement(frame_time, node, component)`` [m], which every run keeps.
    path
        File to write: ``.gif``, ``.html`` (all in one file), or ``.mp4`` where ffmpeg is installed.
    magnification
        Factor of the displacements; None chooses a round one that reads well.
    turning
        Show the attitude; False stays in the floating frame.
    frames
        Number of frames at most, of stored fields evenly apart, 2 to 300.
    rate
        Frames per second.
    dots
        Resolution [dots per inch] of a film of 7 by 5 inches.

    Returns
    -------
    pathlib.Path
        The file. Camera and colours stay the same throughout.

    Raises
    ------
    InputError
        If the run stored fewer than two fields, an argument is out of range, or the file cannot be written.
    MissingExtraError
        If ``.mp4`` is asked for and ffmpeg is not there.

    Examples
    --------
    >>> import tautflex as tf
    >>> run = tf.load_run("m2/run.nc")
    >>> tf.animate(run, "stop.gif", frames=3).name
    'stop.gif'
    """
    remedy = "simulate(..., frames=300) gives one"
    run = dataset_of("run", run, "displacement", "field_time", remedy=remedy, table=RUN)
    if run.sizes.get("frame_time", 0) > run.sizes["field_time"]:
        run = run.drop_dims("field_time").rename(frame_time="field_time", frame_displacement="displacement")
    if run.sizes["field_time"] < 2:
        found = run.sizes["field_time"]
        raise InputError(f"run: expected two stored fields or frames or more, got {found}; simulate with frames=300")
    target = checks.path("path", path)
    writer = _FORMATS[checks.one_of("path", target.suffix, tuple(_FORMATS))]
    if writer is FFMpegWriter and not FFMpegWriter.isAvailable():
        raise MissingExtraError("animate: .mp4 needs ffmpeg, which is not installed; write a .gif or .html")
    if not 2 <= checks.whole("frames", frames, 2) <= _MOST:
        raise InputError(f"frames: expected 2 to {_MOST}, got {frames}")
    checks.positive("rate", rate)
    checks.flag("turning", turning)
    checks.whole("dots", dots, 20)
    stored = run["field_time"].values
    chosen = np.unique(np.linspace(0, stored.size - 1, min(frames, stored.size)).round().astype(int))
    film = _Film(run, chosen, magnification, turning)
    options: dict[str, Any] = {"embed_frames": True} if writer is HTMLWriter else {}
    with written_together(target.parent) as folder:
        writing = writer(fps=rate, **options)
        with writing.saving(film.figure, str(folder / target.name), dots):
            for number in range(len(chosen)):
                film.draw(number)
                writing.grab_frame()
    return target


class _Film:
    """Figure whose frames are drawn one after the other."""

    def __init__(self, run: xr.Dataset, chosen: Array, magnification: float | None, turning: bool) -> None:
        self._times = run["field_time"].values[chosen]
        self._fields = run["displacement"].isel(field_time=chosen).transpose("field_time", "node", "component").values
        turns = map(matrix, recorded_attitude(run, self._times)) if turning else None
        self._mesh, self._turns = wireframe(run), None if turns is None else np.array(list(turns))
        across = float(np.abs(self._fields[..., 2]).max())
        factor = drawn_factor(across, self._mesh.span) if magnification is None else magnification
        self._factor = checks.positive("magnification", factor, remedy="1000 is the paper's")
        self._scale, self._unit = length_unit(across)
        self._limit = (self._scale * across) or 1.0
        self.figure = new_figure(7.0, 5.0, constrained=False)
        self._axes: Any = self.figure.add_axes((0.0, 0.3, 0.86, 0.66), projection="3d")
        bar = self.figure.add_axes((0.87, 0.38, 0.018, 0.5))
        self.figure.colorbar(
            ScalarMappable(Normalize(-self._limit, self._limit), DIVERGING), cax=bar, label=f"$w$ [{self._unit}]"
        )
        record: Any = self.figure.add_axes((0.11, 0.1, 0.75, 0.17))
        if run.sizes.get("probe", 0):
            moves = int(np.abs(run["w"].transpose("time", "probe").values).max(axis=0).argmax())
            name, w = str(run["probe"].values[moves]), run["w"].isel(probe=moves).values
            factor_of_record, unit = length_unit(w)
            record.plot(*thinned(run["time"].values, factor_of_record * w))
            record.set(xlabel="$t$ [s]", ylabel=f"$w_{{\\mathrm{{{name}}}}}$ [{unit}]")
        else:
            record.plot(self._times, self._scale * np.abs(self._fields[..., 2]).max(axis=1))
            record.set(xlabel="$t$ [s]", ylabel=f"largest $|w|$ [{self._unit}]")
        record.margins(x=0.0)
        self._cursor = record.axvline(self._times[0], color="black", linewidth=0.8)
        self._title = self.figure.text(0.02, 0.95, "")

    def draw(self, number: int) -> None:
        """Draw a frame."""
        axes, field = self._axes, self._fields[number]
        turn = np.eye(3) if self._turns is None else self._turns[number]
        mesh = self._mesh
        turned = replace(mesh, nodes=mesh.nodes @ turn.T)
        axes.clear()
        draw_surface(axes, turned, self._factor * field @ turn.T, self._scale * field[:, 2], self._limit)
        half = 0.5 * mesh.span
        middle = mesh.nodes.mean(axis=0) if self._turns is None else np.zeros(3)
        for name, place in zip("xyz", middle, strict=True):
            axes.set(**{f"{name}lim": (place - half, place + half)})
        axes.set_box_aspect((1, 1, 1), zoom=1.55)
        axes.view_init(*VIEW)
        axes.set_axis_off()
        self._cursor.set_xdata([self._times[number]] * 2)
        self._title.set_text(f"$t$ = {self._times[number]:.3f} s    displacements $\\times$ {self._factor:g}")
