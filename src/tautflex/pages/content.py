"""What a page shows of one run, as data for its scripts."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from tautflex.analysis.turning import recorded_attitude
from tautflex.case.prepared import lowest_modes
from tautflex.errors import TautflexError
from tautflex.numeric import Array
from tautflex.pages.curves import curves_of, frequencies_of
from tautflex.pages.encode import packed, plain, quantised
from tautflex.pages.numbers import numbers_of
from tautflex.pages.rebuilt import Structure, stresses_over_time, structure_of
from tautflex.pages.thinning import Drawing, chosen_frames, drawing_of
from tautflex.plot.shapes import drawn_factor
from tautflex.plot.surface import Wireframe
from tautflex.solvers.modal.natural import Modes
from tautflex.solvers.static.prestress import PrestressedState

# Lists of numbers in the text of a case, an entry a line.
_LISTS = re.compile(r"\[\n((?: +[-+.\w]+,\n)+) *\]")
# Bytes of base64 text per byte.
_TEXT = 4.0 / 3.0


def content_of(
    run: xr.Dataset, name: str, folder: Path, state: PrestressedState | None, budget: float
) -> dict[str, Any]:
    """Everything that a page shows of a run, in about ``budget`` bytes; ``state`` in place of the case's."""
    drawing, modes, structure, why = drawing_of(run), None, None, ""
    try:
        structure = structure_of(run, folder) if state is None else Structure(state, _no_inputs(run))
        modes = lowest_modes(structure.state)
    except TautflexError as error:
        why = str(error)
    found: dict[str, Any] = {
        "name": name,
        "title": str(run.attrs.get("title", name)),
        "mesh": mesh_data(drawing.mesh) | _probes(run, drawing.mesh),
        "modes": [] if modes is None else _modes(modes, drawing),
        "modes_missing": why,
    }
    frames, tension, notes = _frames(run, drawing, structure, why, budget)
    found |= frames
    found["curves"] = curves_of(run, tension)
    found["frequencies"] = frequencies_of(run, 0.0 if modes is None else float(modes.frequencies[-1]))
    found["numbers"] = numbers_of(run, modes)
    early = _ended_early(run)
    found["warnings"] = early + list(run.attrs.get("warnings", ()))
    found["versions"] = json.loads(run.attrs.get("versions", "{}"))
    found["case"] = _LISTS.sub(
        lambda some: f"[{', '.join(some[1].replace(',', ' ').split())}]", str(run.attrs.get("case", ""))
    )
    found["maneuver_end"] = float(run.attrs.get("maneuver_end", 0.0))
    notes += early
    if len(drawing.nodes) < run.sizes["node"]:
        notes.append(f"{len(drawing.nodes)} of {run.sizes['node']} nodes are drawn")
    found["notes"] = notes
    result: dict[str, Any] = plain(found)
    return result


def _ended_early(run: xr.Dataset) -> list[str]:
    """That a run did not reach its end, in words, if so."""
    if run.attrs.get("status", "completed") == "completed":
        return []
    return [f"the run ended early, at t = {float(run['time'][-1]):.6g} s; its status says why"]


def _no_inputs(run: xr.Dataset) -> list[Any] | None:
    """Inputs of a run without a case are not known: none where nothing tells of any."""
    return None if "command" in run else []


def mesh_data(mesh: Wireframe) -> dict[str, Any]:
    """A mesh as data for the scene."""
    lines = {"triangles": mesh.triangles, "edges": mesh.edges, "cables": mesh.cables, "beams": mesh.beams}
    found: dict[str, Any] = {name: packed(values) for name, values in lines.items()}
    found |= {"nodes": packed(mesh.nodes), "links": packed(mesh.links), "held": packed(mesh.held)}
    found["span"] = mesh.span
    return found


def _probes(run: xr.Dataset, mesh: Wireframe) -> dict[str, Any]:
    if not run.sizes.get("probe", 0):
        return {}
    places = run["probe_position"].transpose("probe", "component").values
    return {"probes": {"names": [str(name) for name in run["probe"].values], "nodes": nearest_nodes(mesh, places)}}


def nearest_nodes(mesh: Wireframe, places: Array) -> list[int]:
    """Nodes of a drawing that are nearest to places (n, 3)."""
    return [int(np.linalg.norm(mesh.nodes - place, axis=1).argmin()) for place in places]


def _modes(modes: Modes, drawing: Drawing) -> list[dict[str, Any]]:
    data, found = modes.to_dataset(), list[dict[str, Any]]()
    shapes = data["shape"].transpose("mode", "node", "component").values[:, drawing.nodes]
    for frequency, label, shape in zip(modes.frequencies, modes.labels, shapes, strict=True):
        words = "" if label is None else f" ({label[0]},{label[1]})"
        unit = shape / max(float(np.abs(shape).max(initial=0.0)), 1e-300)
        found.append({"name": f"{frequency:.4g} Hz{words}", "frequency": float(frequency), "shape": quantised(unit)})
    return found


def _frames(
    run: xr.Dataset, drawing: Drawing, structure: Structure | None, why: str, budget: float
) -> tuple[dict[str, Any], tuple[Array, Array] | None, list[str]]:
    """Strip of displacements, attitudes, tensions and states of the film; tensions over time; what was left out."""
    stored, moves = run["frame_time"].values, run["frame_displacement"].transpose("frame_time", "node", "component")
    each = _TEXT * (6 * len(drawing.nodes) + 2 * len(drawing.cables) + len(drawing.triangles) + 16)
    some = chosen_frames(stored.size, budget / each) if stored.size else np.zeros(0, dtype=np.int64)
    times, whole = stored[some], moves.isel(frame_time=some).values.astype(np.float64)
    tension, states, notes = None, None, list[str]()
    if some.size < stored.size:
        notes.append(f"{some.size} of {stored.size} frames are shown, {float(np.diff(times).max()):.3g} s apart")
    try:
        if structure is None:
            raise TautflexError(why)
        tension, states = stresses_over_time(structure, times, whole)
    except TautflexError as error:
        why = str(error)
    fields: dict[str, Any] = {}
    if tension is not None and tension.size:
        fields["tension"] = quantised(tension[:, drawing.cables][..., None])
        fields["tension_limits"] = [float(tension.min()), float(tension.max())]
    if states is not None and states.any():
        fields["state"] = packed(states[:, drawing.triangles].astype(np.uint8))
    across = float(np.abs(whole[..., 2]).max(initial=0.0))
    found = {
        "frames": {
            "time": packed(times),
            "displacement": quantised(whole[:, drawing.nodes]),
            "attitude": packed(recorded_attitude(run, times)),
            "largest": across,
            **fields,
        },
        "fields_missing": why,
        "magnification": drawn_factor(across, drawing.mesh.span),
    }
    return found, None if tension is None else (times, tension), notes
