import numpy as np
import pytest

from tautflex import InputError
from tautflex.solvers.modal.labels import FilmSampler, half_wave_labels, symmetry_class


def grid(nx=10, ny=5):
    x, y = np.meshgrid(np.linspace(-1, 1, nx + 1), np.linspace(-0.5, 0.5, ny + 1), indexing="ij")
    return np.column_stack([x.ravel(), y.ravel()])


def scattered(seed=3, count=400):
    """Nodes with no grid: random inside, even along the edges."""
    inside = np.random.default_rng(seed).uniform([-0.97, -0.47], [0.97, 0.47], (count, 2))
    edge = grid(24, 12)
    return np.vstack([inside, edge[(np.abs(edge[:, 0]) == 1) | (np.abs(edge[:, 1]) == 0.5)]])


def sines(nodes, m, n):
    return np.sin(m * np.pi * (nodes[:, 0] + 1) / 2) * np.sin(n * np.pi * (nodes[:, 1] + 0.5))


def partial_wave(s, k, part):
    """Along s in [-1/2, 1/2], k half-waves of which ``part`` fits: what edges on springs do."""
    phase = part * k * np.pi * s
    return np.cos(phase) if k % 2 else np.sin(phase)


WAVES = [(1, 1), (2, 1), (3, 1), (1, 2), (4, 1), (2, 2), (5, 1), (3, 2)]


@pytest.mark.parametrize(("m", "n"), WAVES)
@pytest.mark.parametrize("mesh", ["grid", "scattered"])
def test_fixed_edges(m, n, mesh):
    nodes = grid(20, 10) if mesh == "grid" else scattered()
    film = FilmSampler(nodes)
    w = sines(nodes, m, n)
    assert half_wave_labels(film, w) == (m, n)
    assert half_wave_labels(film, -3e-5 * w) == (m, n)
    assert symmetry_class(film, w) == "AS"[m % 2] + "AS"[n % 2]


@pytest.mark.parametrize(("m", "n"), WAVES)
@pytest.mark.parametrize("part", [0.8, 0.95])
def test_moving_edges(m, n, part):
    nodes = grid()
    w = partial_wave(nodes[:, 0] / 2, m, part) * partial_wave(nodes[:, 1], n, part)
    assert half_wave_labels(nodes, w) == (m, n)


@pytest.mark.parametrize(("m", "n"), [(1, 1), (2, 1), (1, 2), (2, 2)])
@pytest.mark.parametrize("part", [0.3, 0.5])
def test_edges_that_move_most_count_less_than_a_half_wave(m, n, part):
    nodes = grid()
    across = partial_wave(nodes[:, 1], n, 0.8)
    assert half_wave_labels(nodes, partial_wave(nodes[:, 0] / 2, m, part) * across) == (m, n)


def test_noise_and_a_skew_mixture_leave_the_label():
    nodes = grid()
    noise = np.random.default_rng(0).standard_normal(len(nodes))
    w = sines(nodes, 1, 2) + 0.4 * sines(nodes, 4, 1) + 0.03 * noise
    assert half_wave_labels(nodes, w) == (1, 2)


@pytest.mark.parametrize(
    "w",
    [
        np.zeros(66),
        np.ones(66),  # rigid translation
        grid() @ [0.3, 2.0] + 1.0,  # rigid rotation
        sum(sines(grid(), *wave) for wave in [(1, 3), (2, 2), (3, 1), (4, 4)]),  # no product leads
    ],
    ids=["zero", "translation", "rotation", "mixture"],
)
def test_shapes_without_a_label(w):
    assert half_wave_labels(grid(), w) is None


def test_in_plane_motion_has_no_label():
    nodes = grid()
    w = sines(nodes, 2, 1)
    assert half_wave_labels(nodes, w, in_plane=2.0 * np.column_stack([w, w])) is None
    assert half_wave_labels(nodes, w, in_plane=0.3 * np.column_stack([w, w])) == (2, 1)


def test_symmetry_tolerates_a_little_and_not_much():
    nodes = grid()
    mixed = sines(nodes, 1, 2) + 0.15 * sines(nodes, 4, 1)
    assert symmetry_class(nodes, mixed) == "SA"
    assert symmetry_class(nodes, mixed, tolerance=0.99) == "--"
    assert symmetry_class(nodes, sines(nodes, 1, 2) + sines(nodes, 4, 1)) == "--"
    assert symmetry_class(nodes + np.array([3.0, -1.0]), sines(nodes, 2, 1)) == "AS"  # about the nodes' own middle
    assert symmetry_class(nodes, np.zeros(len(nodes))) == "--"


def test_nodes_on_a_line_have_no_label():
    line = np.column_stack([np.linspace(0, 1, 9), np.zeros(9)])
    assert half_wave_labels(line, np.sin(np.pi * line[:, 0])) is None


def test_lengths_must_fit():
    with pytest.raises(InputError, match="w"):
        half_wave_labels(grid(), np.ones(3))
