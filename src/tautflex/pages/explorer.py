"""A reduced antenna as a page that steps it: sliders for tension, slew, damping and control, and a film to push."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from tautflex import checks
from tautflex._version import __version__
from tautflex.case.schema import Case
from tautflex.control.actuators.drive import Drive
from tautflex.control.laws.pd import PD
from tautflex.mechanics.dampings.damping import Damping
from tautflex.motion.fixed_axis import Slew
from tautflex.motion.hub import FreeHub
from tautflex.numeric import within_arithmetic
from tautflex.pages.assemble import assembled, page_file
from tautflex.pages.board import board_of
from tautflex.pages.encode import plain
from tautflex.pages.explorable import explorable
from tautflex.pages.plant_data import plant_data
from tautflex.reduction.polynomial.model import ReducedModel
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.writing import write_text


@within_arithmetic()
def explore(
    model: Case | PrestressedState | ReducedModel,
    path: str | os.PathLike[str],
    *,
    hub: FreeHub | None = None,
    actuators: Mapping[str, Drive] | None = None,
    damping: Damping | None = None,
    law: PD | None = None,
    slew: Slew | None = None,
    title: str = "Membrane antenna on a spacecraft",
) -> Path:
    """Write a reduced antenna on a hub of one axis as one HTML file that steps it, without a network.

    The page holds the polynomial model itself and steps it as `CompiledPlant` does, to round-off: it compares itself
    with a run of Python when it opens, and says how well it agrees. Sliders change tensions, slew, damping and gains
    while it runs; the film is pushed by dragging it.

    Parameters
    ----------
    model
        A case, a prestressed state or a reduced model. What follows is that of the case where it is left out; what
        nobody gives has a stand-in that the page names.
    path
        File to write, ``*.html``.
    hub
        Spacecraft; it turns about one axis, that of the slew if it has several. Stand-in: twice the structure's own
        inertia.
    actuators
        What pulls the structure: those with a limit have a slider. A `HubTorque` limits the attitude control.
        Stand-in: drives that hold the tension of the cables along x and y.
    damping
        Of the structure, which a slider multiplies. Stand-in: ``Rayleigh(1e-3, 1e-3)``.
    law
        Attitude control. Stand-in: 2 rad/s with a damping ratio of 0.8 and feedforward.
    slew
        What the hub follows. Stand-in: 0.5 rad in 2 s, bang-bang.
    title
        Of the page.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    InputError
        If an argument is wrong, the structure cannot be built or reduced, or the loop is not stable.
    NotWrittenError
        If the file cannot be written.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> rom = tf.reduce(state, tf.ModalBasis(directions=("rx",)))
    >>> slew, damping = tf.Slew(angle=0.3, duration=2.0), tf.Rayleigh(1e-3, 1e-3)
    >>> tf.explore(rom, "explorer.html", slew=slew, damping=damping).name
    'explorer.html'
    """
    target = page_file(path, "explorer.html")
    given = explorable(model, hub, actuators, damping, law, slew)
    given.title = checks.instance("title", title, str, "a text")
    data = plant_data(given, board_of(given)) | {"made": f"tautflex {__version__}"}
    return write_text(target, assembled("explorer", given.title, plain(data)))
