"""Hyper-reduced model: a few coordinates and a few weighted elements, for laws that are no polynomials."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
import xarray as xr

from tautflex import checks
from tautflex.elements.block import ElementBlock
from tautflex.mechanics.dampings.damping import Damping
from tautflex.mechanics.inertia import InertiaOperator
from tautflex.mechanics.kernel import add_forces
from tautflex.mechanics.loads.inputs import InputSet, TimeInput
from tautflex.numeric import Array
from tautflex.reduction.bases.snapshots import training_snapshots
from tautflex.reduction.bases.vectors import BasisVectors
from tautflex.reduction.hyper.basis import two_part_basis
from tautflex.reduction.hyper.blocks import basis_blocks, blocks_store, chosen_blocks, rows_of
from tautflex.reduction.hyper.forces import HyperArrays
from tautflex.reduction.hyper.weights import ElementWeights, element_forces, stress_forces, train_weights
from tautflex.reduction.inputs import require_linear
from tautflex.reduction.marching.simulation import solve_reduced
from tautflex.reduction.on_basis import OnBasis, refuse_drifting, refuse_turning
from tautflex.reduction.polynomial.condensation import CondensedModel, FrameMoments, even
from tautflex.reduction.polynomial.projection import project_moments
from tautflex.solvers.static.prestress import PrestressedState, require_state
from tautflex.solvers.transient.problem import Progress, TransientProblem
from tautflex.solvers.transient.restart.keeper import Keeper
from tautflex.solvers.transient.status import Run


@dataclass(frozen=True)
class HyperReducedModel(OnBasis):
    """Structure on a basis with few elements; `simulate` takes it in place of a prestressed state.

    Parameters
    ----------
    state
        The prestressed state that was reduced.
    basis
        Vectors: displacement = eta kept.
    blocks
        Chosen elements; their unknowns are the coordinates, their measures are weighted.
    weights
        Weight of every integration point of the structure, and the error of the training forces.
    seconds
        What the reduction cost [s], without the training run.
    """

    state: PrestressedState
    basis: BasisVectors
    blocks: tuple[ElementBlock, ...]
    weights: ElementWeights
    seconds: float
    in_elements: ClassVar[bool] = True

    @cached_property
    def coefficients(self) -> CondensedModel:
        """Inertia, loads and reference stiffness of the coordinates; nothing follows them."""
        system, vectors = self.state.system, self.basis.kept
        moments = self._moments(system.inertia)
        stiffness = system.pattern.symmetric_matrix(self.state.tangent_entries)
        return CondensedModel(
            mass=even(moments.pair[0]),
            linear=even(vectors @ (stiffness @ vectors.T)),
            quadratic=np.zeros((self.size, 0)),
            cubic=np.zeros((0, 0)),
            viscous=np.zeros((0, 0)),
            turning=moments.pair[1:],
            turning_derivatives=np.zeros((9, 0, self.size)),
            load=moments.load,
            load_stress=np.zeros((12, 0)),
            follow_linear=np.zeros((0, self.size)),
            follow_quadratic=np.zeros((0, 0)),
            follow_load=np.zeros((12, 0)),
        )

    def _moments(self, inertia: InertiaOperator) -> FrameMoments:
        return FrameMoments.general(project_moments(inertia, self.basis.kept))

    def weighed(self, factors: Mapping[str, float]) -> CondensedModel:
        """The same with the inertial load of each kind of element times its factor."""
        linear = self.state.linear
        load = sum(factors[kind] * self._moments(linear.system.inertia_of(kind)).load for kind in linear.system.kinds)
        return self.coefficients._replace(load=load)

    def arrays(self, damping: Damping) -> HyperArrays:
        """Arrays for the compiled stepper under a damping model."""
        c, r = self.coefficients, self.size
        store, rest = blocks_store(list(self.blocks)), rows_of([block.initial_stress for block in self.blocks])
        reference, stresses = np.zeros(r + 1), np.empty(rest.size)
        add_forces(store, np.zeros(r + 1), reference, stresses, True, False, False)
        linear, none = self.state.linear, np.zeros(0, dtype=np.int64)
        matrix = damping.of(linear)
        kinds = linear.projected(self.basis.kept) if matrix.kinds else {}
        return HyperArrays(
            none,
            none,
            c.mass,
            matrix.projected(c.mass, c.linear, self.basis.kept, kinds),
            c.linear,
            np.zeros((0, 0)),
            c.turning.reshape(3, 3, r, r),
            c.turning_derivatives.reshape(3, 3, 0, r),
            store,
            np.concatenate([block.gradient.reshape(-1, r) for block in self.blocks]),
            reference[:-1],
            stresses,
            rest,
            np.zeros((0, rest.size)),
        )

    def restressed(self, arrays: HyperArrays, columns: Mapping[int, Array], answers: Array) -> HyperArrays:
        """Arrays whose elements take n stresses that inputs give (row, strain, n), and what answers them (n, size)."""
        system, count = self.state.system, len(answers)
        blocks = basis_blocks(system, np.concatenate([self.basis.kept, answers]))
        changes = [
            replace(block, initial_stress=columns.get(number, np.zeros((*block.initial_stress.shape, count))))
            for number, block in enumerate(blocks)
        ]
        chosen = [chosen_blocks(each, self.weights.values) for each in (blocks, changes)]
        stress = [block.initial_stress for block in chosen[1]]
        return arrays._replace(
            store=blocks_store(chosen[0]),
            columns=np.array([rows_of([each[..., k] for each in stress]) for k in range(count)]),
        )

    def missed(self, columns: Mapping[int, Array]) -> Array:
        """Part of the stiffness by each of n stresses (row, strain, n) that chosen elements have wrong, shape (n,)."""
        blocks, root = basis_blocks(self.state.system, self.basis.kept), np.sqrt(np.diag(self.coefficients.linear))
        found = list[float]()
        for forces in stress_forces(blocks, np.diag(self.basis.amplitude), columns):
            whole = np.linalg.norm(forces.sum(axis=1) / root)
            wrong = np.linalg.norm(np.einsum("e,ner->nr", self.weights.values - 1.0, forces) / root)
            found.append(float(wrong / whole) if whole > 0.0 else 0.0)
        return np.array(found)

    def solve(self, problem: TransientProblem, progress: Progress = None, keeper: Keeper | None = None) -> Run:
        """Answer a problem asked of it."""
        return solve_reduced(self, problem, progress, keeper)

    @property
    def memory(self) -> int:
        """Bytes of basis and chosen elements."""
        arrays = [self.basis.kept]
        arrays += [a for b in self.blocks for a in (b.gradient, b.elasticity, b.initial_stress, b.measure)]
        return sum(array.nbytes for array in arrays)

    def __repr__(self) -> str:
        return (
            f"HyperReducedModel({self.size} coordinates for {self.state.system.size} unknowns: "
            f"{self.basis.description}; {self.weights.chosen} of {len(self.weights.values)} points, training error "
            f"{self.weights.residual:.2g}; {self.memory / 1e6:.3g} MB, made in {self.seconds:.3g} s)"
        )


def hyper_reduce(
    state: PrestressedState,
    data: xr.Dataset | Sequence[xr.Dataset],
    *,
    transverse: int | None = None,
    in_plane: int | None = None,
    lost: tuple[float, float] = (1e-5, 1e-7),
    tolerance: float = 1e-2,
    training_states: int = 50,
    inputs: Sequence[TimeInput] = (),
) -> HyperReducedModel:
    """Reduce a structure of any law, wrinkling film included, to a few coordinates and a few weighted elements.

    Vectors are proper orthogonal modes of a training run, elements those that reproduce its forces (ECSW, see
    `tautflex.reduction.hyper.weights`). The model is as good as the training run is like the runs it is used for.

    Parameters
    ----------
    state
        Prestressed state.
    data
        Result of a full run (``run.data``) with stored fields, ``simulate(..., fields="all", every=...)``, or several.
    transverse, in_plane
        Number of vectors across and in the film's plane; None takes as many as leave out ``lost``.
    lost
        Parts of the norm of the snapshots across and in the plane that may be left out.
    tolerance
        Error of the training forces at which no more elements are added; 0 keeps all elements, unweighted.
    training_states
        Number of fields at most on which elements are chosen.
    inputs
        Inputs of the runs to come: elements are also to have what tension and temperature do to the stiffness. Runs
        may have others, and say by how much the elements miss them.

    Returns
    -------
    HyperReducedModel

    Raises
    ------
    InputError
        If an argument is out of range, or the run has no fields, or those of another mesh, or an input does not fit
        the structure.
    UnsupportedError
        If the structure can drift away as a rigid body, or an input is not linear in few numbers.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> run = tf.simulate(state, tf.Stop(0.628, 0.1), time_step=0.01, end_time=0.2, fields="all")
    >>> rom = tf.hyper_reduce(state, run.data, transverse=3, in_plane=2)
    >>> rom.size
    5
    """
    began = clock.perf_counter()
    for name, count in (("transverse", transverse), ("in_plane", in_plane)):
        if count is not None:
            checks.whole(name, count, 1)
    require_state(state)
    for share in checks.float_array("lost", lost, (2,)):
        checks.between("lost", share, 0.0, 1.0)
    checks.between("tolerance", tolerance, 0.0, 1.0)
    checks.whole("training_states", training_states, 2)
    refuse_turning(state)
    refuse_drifting(state)
    given = InputSet(state.system, inputs)
    require_linear(given)
    snapshots = training_snapshots(state, data)
    basis = two_part_basis(state, snapshots, (transverse, in_plane), lost)
    blocks = basis_blocks(state.system, basis.kept)
    weights = _train(state, basis, blocks, snapshots, tolerance, training_states, given.columns)
    chosen = tuple(chosen_blocks(blocks, weights.values))
    return HyperReducedModel(state, basis, chosen, weights, clock.perf_counter() - began)


def _train(
    state: PrestressedState,
    basis: BasisVectors,
    blocks: list[ElementBlock],
    snapshots: Array,
    tolerance: float,
    most: int,
    columns: Mapping[int, Array],
) -> ElementWeights:
    """Weights from the states of the basis nearest to some snapshots, and from what stresses do at each vector."""
    if tolerance == 0.0:
        return ElementWeights(np.ones(sum(len(block.measure) for block in blocks)), 0.0)
    mass = state.system.inertia.mass_matrix
    rows = np.unique(np.linspace(0, len(snapshots) - 1, min(most, len(snapshots))).astype(int))
    states = snapshots[rows] @ (mass @ basis.kept.T)
    moving = np.linalg.norm(states, axis=1) > 1e-9 * np.linalg.norm(states, axis=1).max()
    stiffness = state.system.pattern.symmetric_matrix(state.tangent_entries)
    frequencies = np.sqrt(np.einsum("ri,ri->r", basis.kept, (stiffness @ basis.kept.T).T))
    stressed = stress_forces(blocks, np.diag(basis.amplitude), columns)
    return train_weights(np.concatenate([element_forces(blocks, states[moving]), *stressed]), frequencies, tolerance)
