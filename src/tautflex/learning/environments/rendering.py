"""Pictures of an antenna that turns and deforms."""

from __future__ import annotations

import os
import sys
import tempfile
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from tautflex.control.sensors.sensor import hub_rows
from tautflex.learning.environments.loops import Loops
from tautflex.motion.rotations import exponential, matrix
from tautflex.plot.surface import VIEW, draw_surface, wireframe
from tautflex.solvers.variables import mesh_variables

MODES = ("rgb_array", "human")
_EVERY = 4  # intervals between two frames on a screen
_DRAWN = 0.02  # deflection at the task's tolerance, as a part of the structure's length
_FRAME = 1000.0 / 25.0  # of a film [ms]


def picture(loops: Loops, row: int) -> NDArray[np.uint8]:
    """Antenna as it stands, deflections enlarged so that a hundred tolerances are seen, shape (height, width, 3)."""
    arena = loops.arena
    mesh = wireframe(xr.Dataset(mesh_variables(arena.state.model)))
    shift, largest = loops.bodies.displacement(row), 100.0 * arena.task.surface_tolerance
    turn = matrix(exponential(loops.attitude(row) @ hub_rows(arena.hub)[: arena.spec.axes]))
    turned = replace(mesh, nodes=mesh.nodes @ turn.T)
    figure = Figure(figsize=(6.0, 4.5), dpi=80)
    canvas: Any = FigureCanvasAgg(figure)
    axes: Any = figure.add_axes((0.0, 0.0, 1.0, 0.95), projection="3d")
    factor = _DRAWN * mesh.span / largest * 5.0
    draw_surface(axes, turned, factor * shift @ turn.T, shift[:, 2], largest)
    half = 0.5 * mesh.span
    axes.set(xlim=(-half, half), ylim=(-half, half), zlim=(-half, half))
    axes.set_box_aspect((1, 1, 1), zoom=1.5)
    axes.view_init(*VIEW)
    axes.set_axis_off()
    time = max(int(loops.place[row]), 0) * arena.interval
    rms = 1e6 * loops.bodies.readings[row, -1]
    figure.suptitle(f"t = {time:.2f} s, rms {rms:.0f} µm (deflections x {factor:.3g})", fontsize=9)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()


class Screen:
    """Window of an environment; where there is no display, a film in a file.

    Parameters
    ----------
    mode
        One of `MODES`, or None.
    """

    def __init__(self, mode: str | None) -> None:
        self._mode, self._frames = mode, list[Image.Image]()
        self._window: Any = None
        self._file: Path | None = None

    def show(self, loops: Loops, row: int) -> NDArray[np.uint8] | None:
        """Return the picture, or show it where it is time for a new one."""
        if self._mode is None:
            return None
        if self._mode == "rgb_array":
            return picture(loops, row)
        if loops.place[row] % _EVERY == 0:
            self._take(picture(loops, row))
        return None

    def _take(self, image: NDArray[np.uint8]) -> None:
        if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY") or sys.platform in ("win32", "darwin")):
            if self._file is None:
                self._file = Path(tempfile.mkdtemp(prefix="tautflex-")) / "antenna.gif"
                warnings.warn(f"render: no display here; close() writes the frames to {self._file}", stacklevel=4)
            self._frames.append(Image.fromarray(image))
            return
        from matplotlib import pyplot as plt

        if self._window is None:
            plt.ion()
            self._window = plt.figure().add_axes((0.0, 0.0, 1.0, 1.0)).imshow(image)
        self._window.set_data(image)
        plt.pause(1e-3)

    def close(self) -> None:
        """Close the window, or write the film."""
        if self._window is not None:
            from matplotlib import pyplot as plt

            plt.close(self._window.figure)
            self._window = None
        if self._frames and self._file is not None:
            self._frames[0].save(self._file, save_all=True, append_images=self._frames[1:], duration=_FRAME, loop=0)
            self._frames = []
