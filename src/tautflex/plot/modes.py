"""Figure of mode shapes, as in the paper's Figure 3."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from tautflex import checks
from tautflex.plot.panels import draw_shapes
from tautflex.plot.style import saving, styled
from tautflex.plot.surface import wireframe
from tautflex.solvers.modal.natural import Modes
from tautflex.solvers.variables import MODES, dataset_of


@styled
def plot_modes(modes: xr.Dataset | Modes, count: int = 6, columns: int = 3) -> Figure:
    """Draw the first modes as deflected surfaces, coloured by transverse displacement.

    Parameters
    ----------
    modes
        What `tautflex.solve_modes` gives, or a Dataset with ``frequency(mode)`` [Hz], ``shape(mode, node, component)``,
        the mesh, and, where known, ``label_m``, ``label_n`` and ``symmetry``.
    count
        Number of modes, fewer if there are fewer.
    columns
        Drawings side by side.

    Returns
    -------
    matplotlib.figure.Figure
        Every mode is drawn to the same largest translation.

    Raises
    ------
    InputError
        If ``modes`` has no shapes or no mesh, or ``count`` or ``columns`` is below 1.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> figure = tf.plot.plot_modes(tf.solve_modes(state, n=2))
    >>> figure.savefig("modes.png")
    """
    modes = dataset_of("modes", modes, "shape", remedy="solve_modes(state) gives them", table=MODES)
    checks.whole("count", count, 1)
    checks.whole("columns", columns, 1)
    return draw_modes(modes, [mode_title(modes, k) for k in range(min(count, modes.sizes["mode"]))], columns)


save_modes = saving(plot_modes)


def draw_modes(modes: xr.Dataset, titles: Sequence[str], columns: int) -> Figure:
    """Draw as many modes as there are titles."""
    shapes = modes["shape"].transpose("mode", "node", "component").values[: len(titles)]
    largest = np.linalg.norm(shapes, axis=2).max(axis=1)
    return draw_shapes(wireframe(modes), titles, shapes / np.where(largest > 0.0, largest, 1.0)[:, None, None], columns)


def mode_title(modes: xr.Dataset, index: int) -> str:
    """Return e.g. "mode 4   1.99 Hz   (1,2) SA" for a position in a Dataset of modes."""
    one = modes.isel(mode=index)
    number = int(one["mode"]) if "mode" in modes.coords else index + 1
    title = f"mode {number}"
    if "frequency" in modes:
        title += f"   {float(one['frequency']):#.3g}".rstrip(".") + " Hz"
    if "label_m" in modes and int(one["label_m"]) > 0:
        title += f"   ({int(one['label_m'])},{int(one['label_n'])})"
    symmetry = str(one["symmetry"].item()) if "symmetry" in modes else "--"
    return title if symmetry.strip("-") == "" else f"{title} {symmetry}"
