r"""Complex modes of a structure that spins steadily [theory.md 3, 4, 6].

About the spinning equilibrium q0, in the rotating frame: ``M q'' + (C + G) q' + (K_tan(q0) + K_T) q = 0`` with
``G = 2 M(S(w))`` [paper (43)] and ``K_T = M(S(w)^2)`` [paper (44)], hence ``lambda^2 M + lambda (C + G) + K``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from tautflex import checks
from tautflex.errors import InputError
from tautflex.mechanics.dampings.damping import Damping
from tautflex.mechanics.dampings.rayleigh import Rayleigh
from tautflex.mechanics.membrane import survey_at
from tautflex.motion.coupling import Coupling
from tautflex.motion.kinematics import RigidMotion, fixed_axis_motion
from tautflex.numeric import Array, Complex, cross_matrix
from tautflex.solvers.linear.eigenpairs import below_zero
from tautflex.solvers.linear.quadratic import QuadraticPencil, lowest_eigenpairs, quadratic_forms
from tautflex.solvers.modal.natural import describe_shapes
from tautflex.solvers.static.equilibrium import spinning_equilibrium
from tautflex.solvers.static.prestress import PrestressedState, in_short, require_state
from tautflex.solvers.variables import COMPONENTS, SPINNING_MODES, described, mesh_variables
from tautflex.text import card, count, shown, span

# Off every ratio of spin and frequency that a closed form could give.
_SHIFT_PER_RATE = 0.7391
NORMALISATION = "phi^H M phi = 1, largest translation real and positive"


@dataclass(frozen=True)
class SpinningModes:
    """Complex modes about a spinning equilibrium, in order of modulus of their eigenvalues.

    Displacements are ``Re(phi exp(lambda t))`` in the rotating frame.

    Parameters
    ----------
    state
        The prestressed state at rest.
    angular_velocity, origin
        Spin in the frame's axes [rad/s] and a point on its axis [m], shape (3,).
    equilibrium
        Free unknowns of the spinning equilibrium [m, rad], shape (size,).
    eigenvalues
        One of each conjugate pair, imaginary part >= 0 [rad/s], shape (mode,).
    vectors
        Free unknowns, ``phi^H M phi = 1``, largest translation real and positive, shape (mode, size).
    whirl
        Sense of the orbits about the spin axis, seen in the rotating frame, shape (mode,): 1 if all mass moves on
        circles in the sense of the spin (forward), -1 against it (backward), 0 for a standing wave.
    min_principal_resultant
        Smallest principal film resultant of the spinning equilibrium [N/m]; NaN without a film.
    """

    state: PrestressedState
    angular_velocity: Array
    origin: Array
    equilibrium: Array
    eigenvalues: Complex
    vectors: Complex
    whirl: Array
    min_principal_resultant: float

    def __repr__(self) -> str:
        spin, growing = np.linalg.norm(self.angular_velocity), int(np.sum(self.eigenvalues.real > 0.0))
        lines = {
            "state": in_short(self.state),
            "spin": f"{spin:.4g} rad/s about {shown(np.round(self.angular_velocity / (spin or 1.0), 4).tolist())}",
            "modes": f"{len(self.eigenvalues)}, {span(self.frequencies, 'Hz')} in the rotating frame",
            "growth": f"{span(self.eigenvalues.real, '1/s')}, {count(growing, 'growing mode')}",
        }
        return card(self, lines)

    @property
    def frequencies(self) -> Array:
        """Frequencies in the rotating frame ``Im lambda / 2 pi`` [Hz], shape (mode,)."""
        return self.eigenvalues.imag / (2.0 * np.pi)

    @property
    def growth_rates(self) -> Array:
        """Growth rates ``Re lambda`` [1/s], negative where the motion decays, shape (mode,)."""
        return self.eigenvalues.real

    @property
    def damping_ratios(self) -> Array:
        """``-Re lambda / |lambda|``, 0 for zero eigenvalues, shape (mode,)."""
        modulus = np.abs(self.eigenvalues)
        return np.divide(-self.eigenvalues.real, modulus, out=np.zeros_like(modulus), where=modulus > 0.0)

    @cached_property
    def labels(self) -> list[tuple[int, int] | None]:
        """Half-wave numbers (m, n) of transverse film modes, None for others."""
        labels, _ = describe_shapes(self.state, self.shapes.real)
        return labels

    @property
    def stable(self) -> bool:
        """Whether none of these modes grows, but for round-off."""
        return bool(np.all(self.eigenvalues.real <= 1e-9 * np.abs(self.eigenvalues)))

    @property
    def shapes(self) -> Complex:
        """Complex translations of all nodes [kg^-1/2], shape (mode, node, 3)."""
        system = self.state.system
        return system.translations(self.vectors.real) + 1j * system.translations(self.vectors.imag)

    @property
    def data(self) -> xr.Dataset:
        """Modes and mesh as a Dataset, by the name that it has of a run."""
        return self.to_dataset()

    def to_dataset(self) -> xr.Dataset:
        """Modes and mesh as a Dataset; ``shape`` at t = 0, ``shape_quadrature`` a quarter of a period earlier."""
        shapes = self.shapes
        label = np.array([pair or (0, 0) for pair in self.labels])
        data = {
            "frequency": self.frequencies,
            "growth_rate": self.growth_rates,
            "damping_ratio": self.damping_ratios,
            "whirl": self.whirl,
            "shape": shapes.real,
            "shape_quadrature": shapes.imag,
            "label_m": label[:, 0],
            "label_n": label[:, 1],
        }
        return xr.Dataset(
            {**described(SPINNING_MODES, data), **mesh_variables(self.state.model)},
            coords={"mode": np.arange(1, len(self.eigenvalues) + 1), "component": COMPONENTS},
            attrs={
                "title": "complex modes about a spinning equilibrium",
                "normalisation": NORMALISATION,
                "angular_velocity": self.angular_velocity,
                "origin": self.origin,
                "stable": int(self.stable),
                "min_principal_resultant": self.min_principal_resultant,
            },
        )


def solve_spinning_modes(
    state: PrestressedState,
    angular_velocity: ArrayLike,
    origin: ArrayLike = (0.0, 0.0, 0.0),
    n: int = 10,
    coupling: Coupling | None = None,
    damping: Damping | None = None,
) -> SpinningModes:
    """Lowest complex modes of a steadily spinning structure.

    Parameters
    ----------
    state
        Prestressed state.
    angular_velocity
        Constant spin in the frame's axes [rad/s], shape (3,); zeros give the modes at rest.
    origin
        A point on the spin axis [m], shape (3,).
    n
        Number of modes, 1 to the number of free unknowns.
    coupling
        Terms of the rotating frame that are kept, by default all.
    damping
        `Rayleigh`, `Modal` or any other `Damping` of the state at rest, by default none.

    Returns
    -------
    SpinningModes

    Raises
    ------
    InputError
        If an argument has the wrong shape or ``n`` is out of range.
    NotConvergedError
        If there is no spinning equilibrium, or the eigensolver fails.

    Examples
    --------
    >>> import tautflex as tf
    >>> state = tf.solve_prestress(tf.build_model(tf.load_case("m2.toml")))
    >>> tf.solve_spinning_modes(state, (0.0, 0.0, 0.5), n=2).frequencies.round(3).tolist()
    [1.122, 1.431]
    """
    spin, point = checks.vector3("angular_velocity", angular_velocity), checks.vector3("origin", origin)
    require_state(state)
    for name, given, kind in (("coupling", coupling, Coupling), ("damping", damping, Damping)):
        checks.instance(name, given, (kind, type(None)), f"a {kind.__name__} or None")
    system = state.system
    size = system.size
    if not 1 <= checks.whole("n", n, 0) <= size:
        raise InputError(f"n: expected 1 to {size} modes, got {n}; refine the mesh for more")
    motion, coupling = fixed_axis_motion(1.0, 0.0, spin, point), coupling or Coupling()
    equilibrium = spinning_equilibrium(state, motion, coupling)
    pencil = spinning_pencil(state, equilibrium, motion, coupling, damping or Rayleigh())
    rate = float(np.linalg.norm(spin))
    least = below_zero(system.pattern, pencil.stiffness, pencil.mass)
    eigenvalues, vectors = lowest_eigenpairs(pencil, n, max(np.sqrt(least), _SHIFT_PER_RATE * rate))
    vectors = _turned(state, vectors)
    return SpinningModes(
        state,
        spin,
        point,
        equilibrium,
        eigenvalues,
        vectors,
        _whirl(state, spin, vectors),
        survey_at(state.system, equilibrium).membrane().smallest,
    )


def spinning_pencil(
    state: PrestressedState, equilibrium: Array, motion: RigidMotion, coupling: Coupling, damping: Damping
) -> QuadraticPencil:
    """Matrices of small motions about a spinning equilibrium; the damping is that of the state at rest."""
    system = state.system
    inertia = system.inertia
    matrix = damping.of(state.linear)
    return QuadraticPencil(
        system.pattern,
        inertia.mass_entries,
        state.linear.entries(matrix),
        inertia.entries(coupling.velocity_weight(motion)),
        system.tangent(equilibrium) + inertia.entries(coupling.displacement_weight(motion)),
        matrix,
    )


def _turned(state: PrestressedState, vectors: Complex) -> Complex:
    """Vectors with the phase that makes the largest translation real and positive."""
    system, count = state.system, np.arange(len(vectors))
    flat = (system.translations(vectors.real) + 1j * system.translations(vectors.imag)).reshape(len(vectors), -1)
    largest = flat[count, np.abs(flat).argmax(axis=1)]
    return vectors * (np.abs(largest) / largest)[:, None]


def _whirl(state: PrestressedState, spin: Array, vectors: Complex) -> Array:
    """Mass-weighted sense of the orbits ``Im phi^H M(S(axis)) phi`` in [-1, 1]; it is also the weight of G."""
    rate = float(np.linalg.norm(spin))
    if rate == 0.0:
        return np.zeros(len(vectors))
    turning = state.system.inertia.matrix(cross_matrix(spin / rate))
    return quadratic_forms(turning, vectors).imag
