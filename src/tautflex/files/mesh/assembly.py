"""From the groups of a file to the parts of a structure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tautflex.errors import InputError, MeshError
from tautflex.files.mesh import roles
from tautflex.files.mesh.mesh_data import MeshData
from tautflex.files.mesh.raw import KINDS, RawGroup, RawMesh, shorten
from tautflex.files.mesh.raw_links import RawLink, attached, finished
from tautflex.files.mesh.section.spread import in_kilograms, initial_stress, nonstructural, section_numbers, sections
from tautflex.numeric import Indices
from tautflex.structure.groups import DIRECTIONS, Support
from tautflex.structure.links.equation import LinkEquation
from tautflex.structure.links.link import Link
from tautflex.structure.masses import PointMass
from tautflex.structure.mesh import check_elements
from tautflex.structure.shapes import LINE2, QUAD4, TRIANGLE3, TRIANGLE6
from tautflex.structure.springs import Damper, Spring

DEFAULT_ORIENTATION = (0.0, 0.0, 1.0)  # that of Model.from_mesh
# Elements of a structure: where they come from, and the role that makes them such.
_PARTS = {
    "triangles": ("triangles", "membrane"),
    "quads": ("quads", "membrane"),
    "cables": ("lines", "cable"),
    "beams": ("lines", "beam"),
}


def assemble(
    raw: RawMesh,
    names: Mapping[str, str] | None = None,
    unit_length: float = 1.0,
    unit_mass: float | None = None,
) -> MeshData:
    """Give every element its role, leave out what has none, and number nodes anew.

    ``names`` are roles that the user states, by group; they come before the file's element types and names.

    Raises
    ------
    MeshError
        If a group has no role, an element two, or what remains is no mesh.
    """
    stated, problems = roles.stated_roles(names, [group.name for group in raw.groups])
    problems += _doubts(raw, stated)
    role = {kind: np.full(len(raw.elements[kind]), "", dtype="<U8") for kind in KINDS}
    held: list[tuple[str, Indices, tuple[str, ...]]] = []
    left_out, skew = [], list[RawLink]()
    for group in raw.groups:
        own = stated.get(group.name.strip().casefold())
        if own == "":
            continue
        try:
            found = own or _role(raw, group)
        except MeshError as error:
            problems += error.problems
            continue
        if group.links and not own:
            skew += group.links
        elif found in roles.SUPPORTS:
            parts = (raw.elements[kind][group.of(kind)].ravel() for kind in KINDS)
            nodes = np.unique(np.concatenate([group.of("nodes"), *parts]))
            by_name = DIRECTIONS if found == "clamped" else DIRECTIONS[:3]
            held.append((group.name, nodes, by_name if own else group.directions or by_name))
        elif found == "ignore":
            left_out.append(group)
        elif found is not None:
            for kind in _kinds(group):
                problems += _assigned(role[kind], group, found, kind)
    if problems:
        raise MeshError(*dict.fromkeys(problems))
    _fill(raw, role)
    for group in left_out:  # last, because left out is left out, whatever other groups say
        for kind in KINDS:
            role[kind][group.of(kind)] = "ignore"
    return _collect(raw, role, held, skew, unit_length, unit_mass)


def _doubts(raw: RawMesh, stated: Mapping[str, str]) -> Iterator[str]:
    """What is wrong if several groups are left of which the file does not tell which one holds."""
    doubtful = {g.name: g.doubt for g in raw.groups if g.doubt and g.name.strip().casefold() not in stated}
    if len(doubtful) > 1:
        first, *others = doubtful
        text = f"groups {', '.join(doubtful)}: expected {doubtful[first]}, got none; state it"
        yield f"{text}, or leave out all but one with names = {{{others[0]} = 'ignore'}}"


def _role(raw: RawMesh, group: RawGroup) -> str | None:
    """Role of a group without a stated one: what the file holds, what the name says."""
    if group.directions or group.role:
        return group.role or "clamped"
    named = roles.role_of_name(group.name.rpartition(".")[2] if raw.typed else group.name)
    has_elements = bool(_kinds(group))
    if raw.typed and named == "membrane" and _all_shells(raw, group):
        return named
    if not has_elements or raw.typed:  # other node sets and, where types decide, element sets are mere selections
        return named if named in roles.SUPPORTS and (len(group.of("nodes")) or has_elements) else None
    if named is None:
        raise MeshError(roles.no_role(group.name, _kinds(group)))
    return named


def _kinds(group: RawGroup) -> list[str]:
    """Kinds of the elements of a group."""
    return [kind for kind in KINDS if len(group.of(kind))]


def _assigned(role: NDArray[np.str_], group: RawGroup, new: str, kind: str) -> Iterator[str]:
    """Give the elements of a kind in a group their role; what is wrong with it."""
    rows, wrong = group.of(kind), roles.wrong_role(group.name, kind, new, _kinds(group))
    if wrong is not None:
        yield wrong
        return
    clash = (role[rows] != "") & (role[rows] != new)
    if clash.any():
        other = role[rows][clash][0]
        text = f"group {shorten(group.name)}: {int(clash.sum())} of its {kind} are {new} here and {other} by another"
        yield f"{text} group; an element has one role, separate the groups"
    role[rows] = new


def _all_shells(raw: RawMesh, group: RawGroup) -> bool:
    rows = [raw.roles[kind][group.of(kind)] for kind in KINDS]
    return bool(np.all(np.concatenate(rows) == "shell")) and any(len(own) for own in rows)


def _fill(raw: RawMesh, role: dict[str, NDArray[np.str_]]) -> None:
    """Elements without a stated role get what their type says; a file without surfaces in groups is all film."""
    for kind in KINDS:
        role[kind] = np.where(role[kind] == "", raw.roles[kind], role[kind])
    if any(np.any(role[kind] == "shell") for kind in KINDS):
        _refuse_shells(raw, role)
    if not raw.typed and not any(len(group.of("triangles")) + len(group.of("quads")) for group in raw.groups):
        for kind in ("triangles", "quads"):
            role[kind][role[kind] == ""] = "membrane"


def _refuse_shells(raw: RawMesh, role: Mapping[str, NDArray[np.str_]]) -> None:
    left = {kind: role[kind] == "shell" for kind in KINDS}
    names = []
    for group in raw.groups:
        if any(np.any(left[kind][group.of(kind)]) for kind in KINDS):
            names.append(shorten(group.name))
            for kind in KINDS:
                left[kind][group.of(kind)] = False
    if names:
        taken = ", ".join(f"{name}: 'membrane'" for name in names)
        raise MeshError(
            f"group {', '.join(names)}: expected membranes, got shells, whose bending stiffness is not read here; take "
            f"them as membranes with names = {{{taken}}}"
        )


def _collect(
    raw: RawMesh,
    role: Mapping[str, NDArray[np.str_]],
    held: list[tuple[str, Indices, tuple[str, ...]]],
    skew: list[RawLink],
    unit_length: float,
    unit_mass: float | None,
) -> MeshData:
    section = section_numbers(raw, role)
    extra = nonstructural(raw, role, section, unit_length, unit_mass)
    chosen = {}
    for part, (kind, wanted) in _PARTS.items():
        rows = np.flatnonzero(role[kind] == wanted)
        chosen[part] = rows[np.lexsort((rows, extra[kind][rows], section[kind][rows]))]  # those of one section in a row
    elements = {part: raw.elements[_PARTS[part][0]][rows] for part, rows in chosen.items()}
    for part, connectivity in elements.items():
        copies = len(connectivity) - len(np.unique(np.sort(connectivity, axis=1), axis=0))
        if copies:
            raise MeshError(f"{part}: {copies} element(s) join the same nodes as another one; remove the copies")
    used = np.unique(np.concatenate([connectivity.ravel() for connectivity in elements.values()]))
    links, used = attached(raw.links, used)
    if not used.size:
        raise MeshError("mesh: expected triangles, cables or beams, got none; put the elements into named groups")
    new = {part: _renumbering(rows, len(raw.elements[_PARTS[part][0]])) for part, rows in chosen.items()}
    new["nodes"] = _renumbering(used, len(raw.nodes))
    parts: dict[str, Any] = {part: new["nodes"][connectivity] for part, connectivity in elements.items()}
    nodes = raw.nodes[used] * unit_length
    triangle = TRIANGLE6 if parts["triangles"].shape[1] == 6 else TRIANGLE3
    for part, shape in {"triangles": triangle, "quads": QUAD4, "cables": LINE2, "beams": LINE2}.items():
        check_elements(part, shape, nodes, parts[part])
    orientation = np.where(np.isnan(raw.orientation), DEFAULT_ORIENTATION, raw.orientation)[chosen["beams"]]
    stress = {part: initial_stress(raw, _PARTS[part][0], rows, unit_length, unit_mass) for part, rows in chosen.items()}
    strain = {part: raw.strain.get(_PARTS[part][0], np.zeros(0))[rows] for part, rows in chosen.items() if raw.strain}
    supports = _supports([(name, new["nodes"][rows], directions) for name, rows, directions in held])
    skew = list(_held_along(skew, used, elements["beams"], links))
    joined = list(finished([*links, *skew], new["nodes"], unit_length, unit_mass))
    return MeshData(
        nodes,
        **parts,
        supports=supports,
        groups=_selections(raw, new),
        beam_orientation=orientation,
        masses=tuple(_bodies(raw, new["nodes"], unit_length, unit_mass)),
        initial_stress={part: found for part, found in stress.items() if found is not None},
        free_strain={part: found for part, found in strain.items() if found.any()},
        nonstructural_mass={part: extra[_PARTS[part][0]][rows] for part, rows in chosen.items()},
        sections=dict(sections(raw, role, unit_length, unit_mass)),
        links=tuple(one for one in joined if isinstance(one, Link)),
        springs=tuple(one for one in joined if isinstance(one, Spring)),
        dampers=tuple(one for one in joined if isinstance(one, Damper)),
    )


def _held_along(skew: list[RawLink], used: Indices, beams: Indices, links: list[RawLink]) -> Iterator[RawLink]:
    """Supports along turned axes; rotations of nodes that have none are held anyway."""
    there = set(used.tolist())
    turning = {*beams.ravel().tolist(), *(node for raw in links for node in getattr(raw.link, "turning", ()))}
    for raw in skew:
        assert isinstance(raw.link, LinkEquation)
        node, name, _ = raw.link.terms[0]
        if node not in there:
            raise MeshError(f"{raw.where}: its node belongs to no element; correct the support")
        if name in DIRECTIONS[:3] or node in turning:
            yield raw


def _bodies(raw: RawMesh, new: Indices, unit_length: float, unit_mass: float | None) -> Iterator[PointMass]:
    """Rigid bodies in SI units; what a body of no mass and inertia says is nothing."""
    for body in raw.masses:
        node = int(new[body.node])
        if body.mass == 0.0 and not body.inertia.any():
            continue
        if node < 0:
            raise MeshError(f"{body.where}: expected a point mass at a node of an element, got another; join it by one")
        unit = in_kilograms(body.where, unit_length, unit_mass)
        try:
            yield PointMass(
                node, unit * body.mass, unit * unit_length**2 * body.inertia, tuple(unit_length * body.offset)
            )
        except InputError as error:
            raise MeshError(f"{body.where}: {error}") from None


def _renumbering(rows: Indices, count: int) -> Indices:
    """New number of each old row, -1 where it is left out."""
    new = np.full(count, -1, dtype=np.int64)
    new[rows] = np.arange(len(rows))
    return new


def _supports(held: list[tuple[str, Indices, tuple[str, ...]]]) -> tuple[Support, ...]:
    """One support for each set of directions, its nodes in order."""
    rows_of: dict[tuple[str, ...], list[Indices]] = {}
    for name, rows, directions in held:
        there = rows[rows >= 0]
        if not there.size:
            raise MeshError(f"support {shorten(name)}: none of its nodes belongs to an element; correct the group")
        rows_of.setdefault(directions, []).append(there)
    return tuple(
        Support(tuple(np.unique(np.concatenate(parts)).tolist()), directions) for directions, parts in rows_of.items()
    )


def _selections(raw: RawMesh, new: Mapping[str, Indices]) -> dict[str, dict[str, Indices]]:
    """Rows that each name selects; groups of the same name count as one."""
    found: dict[str, dict[str, Indices]] = {}
    for group in raw.groups:
        own = found.setdefault(group.name, {})
        for part, numbers in new.items():
            rows = numbers[group.of(_PARTS[part][0] if part in _PARTS else part)]
            kept = np.union1d(own.get(part, rows[:0]), rows[rows >= 0])
            if kept.size:
                own[part] = kept
    return found
