"""All element blocks of a structure in four flat arrays, so that one compiled call works through all of them.

Handing dozens of arrays to a compiled function costs more than the elements of a small mesh; four arrays cost nothing.
`block_data` cuts a block's lists of non-zero terms out of them again, inside compiled code. Named tuples are handed
over as plain ones, whose types need no look-up.

One row of ``table`` describes a block: sizes, the addresses of its law and of its average, whether its gradients are
seen from a local frame, and where its parts begin in the other arrays. From there they lie one after the other (n rows
of the block; a matrix with n columns is stored line by line):

======== =================================================== ==================================================
array    part                                                numbers
======== =================================================== ==================================================
slots    places of the unknowns in extended vectors          unknowns x n
terms    row, column of non-zero ``gradient`` entries        2 x gradient terms
terms    strain, gradient of non-zero ``linear`` entries     2 x linear terms
terms    strain, first, second of ``quadratic`` entries      3 x quadratic terms
terms    row, column of non-zero ``elasticity`` entries      2 x elastic terms
values   ``gradient`` of each of its terms                   gradient terms x n
values   ``linear``, then ``quadratic``, the same in all rows linear terms + quadratic terms
values   ``elasticity`` of each of its terms                 elastic terms x n
values   initial stress                                      strains x n
values   measure                                             n
values   parameters of the law                               parameters
======== =================================================== ==================================================

A store is good in the process that built it: the address of a law is.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tautflex.elements.block import ElementBlock
from tautflex.numeric import Array, Indices, Places, jit


class KernelStore(NamedTuple):
    """Blocks as compiled code reads them; `block_data` says what is where."""

    slots: Places
    terms: Indices
    values: Array
    table: Indices


class KernelData(NamedTuple):
    """One block as the kernel reads it: lists of non-zero terms; the row is always the last axis."""

    dofs: Places
    gradient_row: Indices
    gradient_column: Indices
    linear_strain: Indices
    linear_gradient: Indices
    quadratic_strain: Indices
    quadratic_first: Indices
    quadratic_second: Indices
    elastic_row: Indices
    elastic_column: Indices
    gradient_value: Array
    linear_value: Array
    quadratic_value: Array
    elastic_value: Array
    initial_stress: Array
    measure: Array
    law_parameters: Array
    gradients: int
    law: int
    average: int
    turns: int


# Columns of the table.
_ROWS, _UNKNOWNS, _STRAINS, _GRADIENTS, _LAW, _PARAMETERS = range(6)
_GRADIENT_TERMS, _LINEAR_TERMS, _QUADRATIC_TERMS, _ELASTIC_TERMS = range(6, 10)
_AVERAGE, _TURNS, _FIRST_SLOT, _FIRST_TERM, _FIRST_VALUE = range(10, 15)
_COLUMNS = 15

# In place of the address of a compiled law, and of that of its average: numerically.
ELASTIC = INTEGRATED = 0


def build_store(blocks: tuple[ElementBlock, ...], dofs: list[Places], initial_stress: list[Array]) -> KernelStore:
    """Compress blocks, the places of their unknowns (dof, row) and initial stresses (row, strain) for the kernel."""
    slots, terms, values = list[Places](), list[Indices](), list[Array]()
    table = np.zeros((len(blocks), _COLUMNS), dtype=np.int64)
    starts = np.zeros(3, dtype=np.int64)
    for row, block, places, stress in zip(table, blocks, dofs, initial_stress, strict=True):
        gradient = np.nonzero(np.any(block.gradient != 0.0, axis=0))
        linear, quadratic = np.nonzero(block.linear), np.nonzero(block.quadratic)
        elastic = np.nonzero(np.any(block.elasticity != 0.0, axis=0))
        count, unknowns = places.shape[1], places.shape[0]
        law, parameters = block.law.function, block.law.parameters(block.material)
        address, average = (0 if compiled is None else compiled.address for compiled in (law, block.law.average))
        sizes = (count, unknowns, len(block.linear), block.gradient.shape[1], address, len(parameters))
        terms_each = gradient[0].size, linear[0].size, quadratic[0].size, elastic[0].size
        row[:_FIRST_SLOT] = *sizes, *terms_each, average, block.turns
        row[_FIRST_SLOT:] = starts
        slots.append(np.ascontiguousarray(places).ravel())
        terms.extend([*gradient, *linear, *quadratic, *elastic])
        values.extend(
            [
                block.gradient[:, gradient[0], gradient[1]].T.ravel(),
                block.linear[linear],
                block.quadratic[quadratic],
                block.elasticity[:, elastic[0], elastic[1]].T.ravel(),
                np.asarray(stress).T.ravel(),
                block.measure,
                np.array(parameters, dtype=float),
            ]
        )
        starts[:] = [sum(piece.size for piece in pieces) for pieces in (slots, terms, values)]
    return KernelStore(
        np.concatenate([np.zeros(0, dtype=np.uint32), *slots]),
        np.concatenate([np.zeros(0, dtype=np.int64), *terms]),
        np.concatenate([np.zeros(0), *values]),
        table,
    )


@jit
def block_data(store: Any, block: int) -> Any:
    """Views of one block's terms, a `KernelData`; ``py_func`` gives them outside compiled code."""
    all_slots, terms, values, table = store
    row = table[block]
    count, unknowns, strains = row[_ROWS], row[_UNKNOWNS], row[_STRAINS]
    slot, t, v = row[_FIRST_SLOT], row[_FIRST_TERM], row[_FIRST_VALUE]
    gradient, linear = row[_GRADIENT_TERMS], row[_LINEAR_TERMS]
    quadratic, elastic = row[_QUADRATIC_TERMS], row[_ELASTIC_TERMS]
    t1 = t + 2 * gradient
    t2 = t1 + 2 * linear
    t3 = t2 + 3 * quadratic
    t4 = t3 + 2 * elastic
    v1 = v + gradient * count
    v2 = v1 + linear
    v3 = v2 + quadratic
    v4 = v3 + elastic * count
    v5 = v4 + strains * count
    v6 = v5 + count
    return KernelData(
        all_slots[slot : slot + unknowns * count].reshape((unknowns, count)),
        terms[t : t + gradient],
        terms[t + gradient : t1],
        terms[t1 : t1 + linear],
        terms[t1 + linear : t2],
        terms[t2 : t2 + quadratic],
        terms[t2 + quadratic : t2 + 2 * quadratic],
        terms[t2 + 2 * quadratic : t3],
        terms[t3 : t3 + elastic],
        terms[t3 + elastic : t4],
        values[v:v1].reshape((gradient, count)),
        values[v1:v2],
        values[v2:v3],
        values[v3:v4].reshape((elastic, count)),
        values[v4:v5].reshape((strains, count)),
        values[v5:v6],
        values[v6 : v6 + row[_PARAMETERS]],
        row[_GRADIENTS],
        row[_LAW],
        row[_AVERAGE],
        row[_TURNS],
    )
