"""Sparsity pattern against dense algebra, and packs of elements against the same elements one by one."""

import numpy as np
import pytest

from tautflex import Material, MembraneSection, Model
from tautflex.mechanics.pattern import SparsityPattern
from tautflex.mechanics.system import StructuralSystem
from tautflex.structure.mesh import rectangle_mesh
from tautflex.structure.model import Support


def test_pattern_is_the_union_of_element_blocks():
    rng, size = np.random.default_rng(0), 40
    # Repeated unknowns, supported ones (number ``size``) and an unknown that no element has.
    elements = [rng.integers(1, size + 1, (25, 3)), rng.integers(1, size + 1, (4, 6))]
    expected = np.eye(size + 1, dtype=bool)
    for dofs in elements:
        for row in dofs:
            expected[np.ix_(row, row)] = True
    pattern = SparsityPattern.from_elements(size, elements)
    found = pattern.matrix(np.ones(pattern.entries)).toarray().astype(bool)
    np.testing.assert_array_equal(found, expected[:size, :size])
    assert all(np.all(np.diff(rows) > 0) for rows in np.split(pattern.rows, pattern.column_start[1:-1]))


def test_slots_find_every_entry_and_send_supported_ones_behind_the_last():
    rng, size = np.random.default_rng(1), 30
    elements = [rng.integers(0, size + 1, (20, 4))]
    pattern = SparsityPattern.from_elements(size, elements)
    slots = pattern.element_slots(elements[0])
    for element, dofs in enumerate(elements[0]):
        for i, row in enumerate(dofs):
            for j, column in enumerate(dofs):
                slot = slots[i, j, element]
                if row == size or column == size:
                    assert slot == pattern.entries
                else:
                    assert (pattern.rows[slot], pattern.columns[slot]) == (row, column)
    np.testing.assert_array_equal(pattern.slots(pattern.rows, pattern.columns), np.arange(pattern.entries))
    values = rng.standard_normal(pattern.entries)
    transposed = pattern.matrix(values[pattern.transpose_slots]).toarray()
    np.testing.assert_array_equal(transposed, pattern.matrix(values).toarray().T)


@pytest.mark.parametrize("law", ["elastic", "tension-field"])
@pytest.mark.slow
def test_packs_sum_what_their_elements_give_alone(law):
    """400 triangles fill packs of the kernel and leave a part of one; each triangle is also a film of its own."""
    section = MembraneSection(Material(3.5e9, 1530.0, 0.34), 1e-4, "green-lagrange", law)
    nodes, triangles = rectangle_mesh(np.linspace(0.0, 2.0, 21), np.linspace(0.0, 1.0, 11))
    rng = np.random.default_rng(2)
    stress = rng.uniform(1e4, 3e5, (len(triangles), 3)) * [1.0, 1.0, 0.3]
    held = (Support.pinned(np.flatnonzero(nodes[:, 0] == 0.0)),)
    whole = StructuralSystem.from_model(
        Model.from_mesh(nodes, triangles=triangles, membrane=section, membrane_stress=stress, supports=held)
    )
    q = 1e-4 * rng.standard_normal(whole.size)
    force, energy = whole.force(q)
    moved, summed, work = whole.full(q), np.zeros(whole.model.dof_count), 0.0
    tangent = np.zeros((whole.model.dof_count,) * 2)
    for corners, own in zip(triangles, stress, strict=True):
        model = Model.from_mesh(nodes[corners], triangles=[[0, 1, 2]], membrane=section, membrane_stress=own)
        alone = StructuralSystem.from_model(model)
        dofs = whole.model.translation_dofs[corners].ravel()
        part, share = alone.force(moved[dofs])
        summed[dofs] += part
        tangent[np.ix_(dofs, dofs)] += alone.matrix(alone.tangent(moved[dofs])).toarray()
        work += share
    free = whole.model.free_dofs
    np.testing.assert_allclose(force, summed[free], rtol=1e-9, atol=1e-11 * np.abs(force).max())
    assert energy == pytest.approx(work, rel=1e-10)
    assert whole.workspace().strain_energy(q) == pytest.approx(energy, rel=1e-14)
    found = whole.matrix(whole.tangent(q)).toarray()
    np.testing.assert_allclose(found, tangent[np.ix_(free, free)], rtol=1e-9, atol=1e-11 * np.abs(found).max())
    np.testing.assert_array_equal(found, found.T)
