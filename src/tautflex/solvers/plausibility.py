"""Plausibility: what lies beyond the theory or beyond what people build: how much, where, when and what to do.

Nothing is refused here that arithmetic can hold. Silence means that every number below stayed within its limit.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import eigh

from tautflex.errors import InputError
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.mechanics.membrane import principal_values
from tautflex.mechanics.system import StructuralSystem
from tautflex.motion.kinematics import Maneuver
from tautflex.numeric import Array, Indices
from tautflex.structure.materials import BeamSection, MembraneSection
from tautflex.structure.mesh import linked_pieces
from tautflex.structure.model import Model

PRESTRAIN = 0.01  # the reference shape stands for the unstressed one
STRAIN = 0.05  # linear elasticity
ASTRAY = 0.05  # [rad], of a force that keeps its direction
SLOPE = 0.3  # von Karman strains leave out slope^4/8 beside slope^2/2: 1 % of it
ROTATION = 0.2  # [rad], beams whose rotations add up like vectors
NEARLY_ROUND = 6.0  # [rad], nearly the whole turn at which rotation vectors lose two directions
IMBALANCE = 0.05  # of the largest force of an element, carried by the reference state
TURN = 2.0 * np.pi  # [rad], of one maneuver
TURN_IN_STEP = 0.5  # [rad]: Coriolis forces turn motion round as fast as the frame
LOST = 1e-6  # [rad], of an angle by its round-off
STILL = 1e-3  # [Hz], of a rigid motion that nothing holds
THICKNESS = 0.01  # of the shorter span: beyond it a film is a plate
FEW_STEPS = 5  # in a maneuver: with fewer a run may miss it
_SAME_PLACE = 1e-6  # of the largest extent
_NEIGHBOURS = 16  # triangles around a place that are looked at for overlaps
_FEW = 512  # triangles that are all looked at
_ASKEW = np.array([0.525, 0.618, 0.584])  # shorter than 1, along and across no side that people build


def place_of(model: Model, kind: str, element: int) -> str:
    """Centre of an element, numbered through all of its kind, in words."""
    return point_text(model.centre(kind, element))


def point_text(position: Array) -> str:
    """A position [m] in words."""
    return "(" + ", ".join(f"{value:.3g}" for value in position) + ") m"


def doubts_about_structure(model: Model) -> list[str]:
    """Film as thick as a plate, nodes at one place, elements on top of each other, links that hold against turning."""
    found = [*_thick_film(model), *_coincident_nodes(model), *_overlapping_film(model), *_doubled_lines(model)]
    return [*found, *_holding_links(model)]


def _holding_links(model: Model) -> list[str]:
    if not model.links:
        return []
    held = model.freedom_of(np.full(len(model.nodes), True), supports_alone=True) - model.rigid_freedom
    if not held:
        return []
    return [
        f"links and springs hold the structure against {held} rigid motion(s) that its supports leave free: ties and "
        "equations between nodes at different places take moments from nowhere; use rigid links"
    ]


def _tree(points: Array) -> Any:
    from scipy.spatial import cKDTree  # a tenth of the time that `tautflex check` takes, and small meshes do without

    return cKDTree(points)


def _thick_film(model: Model) -> list[str]:
    if not model.surfaces:
        return []
    film = model.nodes[np.unique(model.triangles)]
    axes = np.linalg.svd(film - film.mean(axis=0), full_matrices=False)[2]
    span = float(np.ptp(film @ axes.T, axis=0)[1])
    sections = [group.section for group in model.surfaces if isinstance(group.section, MembraneSection)]
    thickness = max((section.thickness for section in sections), default=0.0)
    if thickness <= THICKNESS * span:
        return []
    return [
        f"the film is {thickness:.3g} m thick, {thickness / span:.1%} of its shorter span of {span:.3g} m: bending, "
        f"which a membrane does not have, matters beyond {THICKNESS:.0%}; give the thickness in metres"
    ]


def _coincident_nodes(model: Model) -> list[str]:
    radius = _SAME_PLACE * float(np.ptp(model.nodes, axis=0).max())
    # No two are nearer to each other than along a line.
    if np.all(np.diff(np.sort(model.nodes @ _ASKEW)) > radius):
        return []
    pairs = _tree(model.nodes).query_pairs(radius, output_type="ndarray")
    # Of links between held nodes nothing is left but their names.
    named = [(link.joined[0], node) for link in model.links for node in link.joined[1:]]
    linked = np.concatenate([model.linked_pairs, np.reshape(named, (-1, 2)).astype(np.int64)])
    piece = linked_pieces(len(model.nodes), linked)
    pairs = pairs[piece[pairs[:, 0]] != piece[pairs[:, 1]]]
    if not len(pairs):
        return []
    a, b = pairs[np.lexsort(pairs.T[::-1])[0]].tolist()
    return [
        f"nodes {a} and {b} lie at the same place {point_text(model.nodes[a])} but are not joined ({len(pairs)} such "
        "pair(s)): the structure is slit there; merge them, or move them apart"
    ]


def _overlapping_film(model: Model) -> list[str]:
    """Film elements whose linear triangles hold the centre of another element's."""
    corners, owner = model.nodes[model.triangles], model.triangle_owner
    if len(corners) < 2:
        return []
    centre = corners.mean(axis=1)
    count = len(centre)
    near: Indices = np.broadcast_to(np.arange(count), (count, count))
    if count > _FEW:
        near = np.asarray(_tree(centre).query(centre, k=_NEIGHBOURS)[1])
    first, last = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(first, last)
    size = np.sum(normal**2, axis=1)
    offset = centre[near] - corners[:, None, 0]
    one = np.einsum("nkx,nx->nk", offset, np.cross(last, normal)) / size[:, None]
    other = np.einsum("nkx,nx->nk", offset, np.cross(normal, first)) / size[:, None]
    height = np.abs(np.einsum("nkx,nx->nk", offset, normal)) / size[:, None] ** 0.75
    inside = (np.minimum(one, other) > 1e-6) & (one + other < 1.0 - 1e-6) & (height < 1e-6)
    inside &= owner[near] != owner[:, None]
    if not inside.any():
        return []
    row, column = np.argwhere(inside)[0]
    a, b = sorted((int(owner[row]), int(owner[near[row, column]])))
    many = len(np.unique(owner[np.any(inside, axis=1)]))
    return [
        f"film elements {a} and {b} lie on top of each other at {point_text(centre[near[row, column]])} ({many} such "
        "element(s)): mass and stiffness count twice there; remove one"
    ]


def _doubled_lines(model: Model) -> list[str]:
    found = []
    for kind, lines in (("cable", model.cables), ("beam", model.beams)):
        ends, which, count = np.unique(np.sort(lines, axis=1), axis=0, return_inverse=True, return_counts=True)
        if np.any(count > 1):
            twice = np.flatnonzero(count > 1)
            a, b = np.flatnonzero(which.ravel() == twice[0])[:2].tolist()
            found.append(
                f"{kind}s {a} and {b} both join nodes {ends[twice[0]].tolist()} ({len(twice)} such pair(s)): mass and "
                "stiffness count twice there; remove one"
            )
    return found


def doubts_about_prestress(system: StructuralSystem) -> list[str]:
    """Prestrain beyond what leaves the reference shape the unstressed one."""
    strain = measure(system, np.zeros(system.size))["strain"]
    if strain.value <= PRESTRAIN:
        return []
    return [
        f"the prestrain is {strain.value:.1%} in {strain.kind} {strain.element} at "
        f"{place_of(system.model, strain.kind, strain.element)}, beyond {PRESTRAIN:.0%} the reference shape no longer "
        "stands for the unstretched one; check tensions, thickness and modulus, and their units"
    ]


def doubts_about_links(system: StructuralSystem, tangent: Array) -> list[str]:
    """Links of a free structure in balance that do not turn the forces which its prestress sends through them.

    Averages of nodes, ties in some directions and arms at the ends of corotational beams move to first order alone, so
    that forces in them resist a turn of the whole: what elements that strain nothing leave of ``tangent`` (entries,).
    """
    model = system.model
    exact = all(group.section.strain != "von-karman" for group in model.groups)
    if not (model.links and exact and model.rigid_freedom == 6):
        return []
    motions = model.rigid_motions[model.free_dofs]
    stiffness, mass = (motions.T @ (system.matrix(one) @ motions) for one in (tangent, system.inertia.mass_entries))
    fastest = float(np.sqrt(np.abs(eigh(stiffness, mass, eigvals_only=True)).max()) / TURN)
    if fastest <= STILL:
        return []
    return [
        f"links carry forces of the prestress that do not turn with them: rigid motions of the free structure have up "
        f"to {fastest:.2g} Hz in place of 0; lead such forces through rigid links, and not at the ends of corotational "
        "beams, or through stiff beams"
    ]


def imbalance_text(residual: float, share: float) -> str:
    """Sentence about forces [N] that the reference is taken to carry, a share of the largest force of an element."""
    return (
        f"the given prestress does not balance: {residual:.3g} N, {share:.0%} of the largest force of an element, is "
        "taken as carried by the reference state; set prestress mode 'equilibrium' for a structure in true equilibrium"
    )


class Reading(NamedTuple):
    """The largest value of a measure, and the element that has it (-1: there is none)."""

    value: float = 0.0
    kind: str = ""
    element: int = -1


def measure(system: StructuralSystem, q: Array) -> dict[str, Reading]:
    """Largest ``strain`` [-], ``slope`` [-], ``rotation`` [rad] ... at free unknowns [m, rad], shape (size,).

    Strains are principal ones of film, axial ones of cables and beams, those of the prestress included. Slopes are
    those of film and cables with von Karman strains, rotations those of beams' ends that take them as small, turns
    those of corotational beams, of bodies on them and of rigidly linked nodes; all are relative to the floating frame.
    """
    extended, first = np.append(q, 0.0), dict[str, int]()
    worst = dict.fromkeys(_REMEDY, Reading())
    for block, initial, places, group in zip(
        system.blocks, system.initial_stress, system.row_places, system.model.element_groups, strict=False
    ):
        g = np.einsum("nij,nj->ni", block.gradient, extended[places])
        stress = initial + np.einsum("nst,nt->ns", block.elasticity, block.strain(extended[places]))
        # What a cable strains, not what a tendon or a drive in series with it gives way.
        modulus = block.material.youngs_modulus if block.kind == "cable" else block.elasticity[:, 0, 0]
        found = {"strain": np.abs(stress[:, 0]) / modulus}
        if block.kind == "membrane":
            # Of the strain that the stress stands for; principal values of stresses have no factor 2 in the shear.
            elastic = np.linalg.solve(block.elasticity, stress[:, :, None])[:, :, 0] * (1.0, 1.0, 0.5)
            found["strain"] = np.abs(principal_values(elastic)).max(axis=1)
        if isinstance(group.section, BeamSection):
            turned = np.linalg.norm(g[:, 3:9].reshape(-1, 2, 3), axis=2)
            if block.turns:
                found["turn"] = turned.max(axis=1)
                carried = np.isin(group.connectivity, [body.node for body in system.model.masses if body.turns])
                found["turn of a point mass"] = np.max(turned, axis=1, where=carried, initial=0.0)
            else:
                found["rotation"] = turned.max(axis=1)
        elif group.section.strain == "von-karman":
            found["slope"] = np.linalg.norm(g[:, 4:6] if block.kind == "membrane" else g[:, 1:3], axis=1)
        start = first.get(block.kind, 0)
        for name, values in found.items():
            row = int(np.argmax(values))
            if values[row] > worst[name].value:
                element = row if block.owner is None else int(block.owner[row])
                worst[name] = Reading(float(values[row]), block.kind, start + element)
        first[block.kind] = start + len(block.dofs)
    # Links without length copy turns of any size.
    long = [link for link in system.model.links if np.ptp(system.model.nodes[list(link.joined)], axis=0).any()]
    leading = np.array(sorted({node for link in long for node in link.turning}), dtype=np.int64)
    if leading.size:
        dofs = system.model.dof_offset[leading][:, None] + np.arange(3, 6)
        turned = np.linalg.norm(system.full(q)[dofs], axis=1)
        worst["turn of a link"] = Reading(float(turned.max()), "linked node", int(leading[turned.argmax()]))
    return worst


_REMEDY = {
    "strain": (
        STRAIN,
        ".1%",
        "linear elasticity is doubtful beyond 5 %; check loads and units, or the material's limit",
    ),
    "slope": (SLOPE, ".2f", "von Karman strains hold up to slopes of 0.3; set strain = 'green-lagrange'"),
    "rotation": (ROTATION, ".2f", "these beams take rotations as small, up to 0.2 rad; set strain = 'corotational'"),
    "turn": (
        NEARLY_ROUND,
        ".2f",
        "a node that a whole turn, 6.28 rad, sets apart from the frame's axes loses stiffness",
    ),
    "turn of a point mass": (
        ROTATION,
        ".2f",
        "its offset and inertia turn as by small angles, up to 0.2 rad; give it a node of its own at its centre",
    ),
    "turn of a link": (
        ROTATION,
        ".2f",
        "links take turns as small, up to 0.2 rad: its arms end {astray:.0%} of their length away from where they "
        "should; stiffen or move it less, or make its arms of stiff corotational beams",
    ),
}


class MotionWatch:
    """Follows a run and says how far strains, slopes and rotations went.

    They are measured at the instants of largest strain energy and of largest displacement, when the run has ended.

    Attributes
    ----------
    largest
        Largest strain energy [J] and largest ``q . q`` of the stored instants, each with its time [s], shape (2, 2).
    places
        Free unknowns [m, rad] at these times, shape (2, size).
    """

    def __init__(self, system: StructuralSystem, inputs: InputSet | None = None) -> None:
        self._inputs = [] if inputs is None else inputs.named
        self._system = system
        self.largest, self.places = np.zeros((2, 2)), np.zeros((2, system.size))

    def warnings(self) -> list[str]:
        """Sentences with how much, where, when and what to do; empty if there is nothing to say."""
        kept = [(time, q) for (value, time), q in zip(self.largest.tolist(), self.places, strict=True) if value > 0.0]
        measured = [(time, measure(self._system, q)) for time, q in kept]
        found = []
        for name, (limit, style, remedy) in _REMEDY.items():
            time, worst = max(
                ((t, each[name]) for t, each in measured), key=lambda r: r[1].value, default=(0.0, Reading())
            )
            if worst.value > limit:
                at = f"{worst.kind} {worst.element} at {place_of(self._system.model, worst.kind, worst.element)}"
                # Of an arm at right angles: what turns it less the turn that it takes.
                astray = abs(np.exp(1j * worst.value) - 1.0 - 1j * worst.value)
                found.append(
                    f"the {name} reached {worst.value:{style}} at t = {time:.4g} s in {at}: "
                    + remedy.format(astray=astray)
                )
        for name, item in self._inputs:
            angle, time = max(((item.turned(q), time) for time, q in kept), default=(0.0, 0.0))
            if angle > ASTRAY:
                found.append(
                    f"inputs: the pull of {name} keeps its direction, which motion turned by {angle:.2g} rad at "
                    f"t = {time:.4g} s: that share of it is missing across; put its anchor farther away"
                )
        return found


def doubts_about_maneuver(maneuver: Maneuver, time_step: float | None = None, end_time: float = 0.0) -> list[str]:
    """A maneuver that turns the frame by more than a revolution, as angles in degrees do, or far in a step.

    Raises
    ------
    InputError
        If round-off leaves the direction unknown to which it turns the frame until ``end_time`` [s].
    """
    angle, fastest = 0.0, 0.0
    abscissa, weight = np.polynomial.legendre.leggauss(16)
    instants = np.concatenate([[-1.0, 0.0, 1.0], abscissa])
    *moving, last = maneuver.segments()
    for segment in moving:
        half = 0.5 * (segment.end - segment.start)
        rates = [np.linalg.norm(segment.motion(segment.start + half * (1.0 + x)).angular_velocity) for x in instants]
        angle, fastest = angle + half * float(weight @ rates[3:]), max(fastest, float(max(rates)))
    steady = float(np.linalg.norm(last.motion(last.start).angular_velocity))
    fastest, found = max(fastest, steady), list[str]()
    whole = angle + steady * max(end_time - last.start, 0.0)
    if not whole * np.finfo(float).eps <= LOST:
        raise InputError(
            f"maneuver: expected angles that arithmetic resolves to {LOST:g} rad, got {whole:.3g} rad in all; check "
            "angle and rates, in rad and rad/s"
        )
    if angle > TURN * (1.0 + 1e-6):
        found.append(
            f"the maneuver turns the frame by {angle:.4g} rad, {angle / TURN:.3g} revolutions, until "
            f"t = {maneuver.end:.4g} s; angles are in rad: {angle:.4g} degrees are {np.radians(angle):.4g}"
        )
    if time_step is not None and fastest * time_step > TURN_IN_STEP:
        found.append(
            f"the frame turns by up to {fastest * time_step:.3g} rad in a time_step of {time_step:g} s, and motion in "
            f"it goes round as fast: the steps do not see that; set time_step = {0.1 / fastest:.2g} s or less"
        )
    return found


def short_motions(maneuver: Maneuver, time_step: float) -> list[float]:
    """Durations [s] of a maneuver and of those it consists of that have fewer than `FEW_STEPS` steps [s]."""
    lasting = [getattr(part, "duration", None) for part in (maneuver, *getattr(maneuver, "steps", ()))]
    least = FEW_STEPS * time_step * (1.0 - 1e-9)
    return [float(duration) for duration in lasting if duration is not None and duration < least]


def doubts_about_probes(model: Model, asked: Mapping[str, ArrayLike], read: Array) -> list[str]:
    """Probes read at a node that is farther away than any element there is long: they lie beside the structure."""
    found = []
    lengths = [
        (group.connectivity, np.ptp(model.nodes[group.connectivity], axis=1).max(axis=1)) for group in model.groups
    ]
    for (name, position), place in zip(asked.items(), read, strict=True):
        point = np.asarray(position, dtype=float).ravel()
        away = float(np.linalg.norm(place[: point.size] - point))
        node = int(np.argmin(np.sum((model.nodes - place) ** 2, axis=1)))
        reach = max(float(length[np.any(nodes == node, axis=1)].max(initial=0.0)) for nodes, length in lengths)
        if away > reach:
            found.append(
                f"probe {name} is read {away:.3g} m away from where it was asked for, at node {node} "
                f"{point_text(place)}, farther than its elements are long ({reach:.3g} m); put it on the structure"
            )
    return found
