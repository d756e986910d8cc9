import numpy as np
import pytest
import xarray as xr
from scipy import sparse

from tautflex import InputError, dominant_shape, pod

SNAPSHOTS, DOFS = 200, 24
HEIGHTS = np.array([3.0, 0.4, 0.05])


def known_field(weight=None, seed=0):
    """Three shapes orthonormal in the weight, moved by three orthogonal histories of unit mean square."""
    rng = np.random.default_rng(seed)
    if weight is None:
        shapes = np.linalg.qr(rng.standard_normal((DOFS, 3)))[0].T
    else:
        factor = np.linalg.cholesky(weight)  # W = L L^T; the columns of L^-T Q are orthonormal in W
        shapes = np.linalg.solve(factor.T, np.linalg.qr(rng.standard_normal((DOFS, 3)))[0]).T
    phase = 2 * np.pi * np.arange(SNAPSHOTS) / SNAPSHOTS
    histories = np.sqrt(2) * np.array([np.cos(phase), np.cos(2 * phase + 0.4), np.sin(3 * phase + 0.2)])
    return shapes, (HEIGHTS[:, None] * histories).T @ shapes


def weight_matrix():
    rng = np.random.default_rng(5)
    coupled = sparse.random_array((DOFS, DOFS), density=0.15, rng=rng)
    return (coupled @ coupled.T + sparse.diags_array(rng.uniform(0.5, 2.0, DOFS))).tocsc()


def check_modes(result, shapes):
    share = HEIGHTS**2 / np.sum(HEIGHTS**2)
    np.testing.assert_allclose(result["value"], HEIGHTS**2, rtol=1e-10)
    np.testing.assert_allclose(result["participation"], share, rtol=1e-10)
    np.testing.assert_allclose(result["cumulative"], np.cumsum(share), rtol=1e-12)
    found = result["shape"].values.reshape(3, -1)
    signs = np.sign(np.sum(found * shapes, axis=1))
    np.testing.assert_allclose(found, signs[:, None] * shapes, atol=1e-10)
    largest = np.abs(found).argmax(axis=1)
    assert np.all(found[np.arange(3), largest] > 0)


def test_rank_three_field_is_recovered():
    shapes, field = known_field()
    result = pod(field, modes=10)
    assert result.sizes["mode"] == 3  # the rank, not the ten asked for
    check_modes(result, shapes)
    rebuilt = result["coefficient"].values @ result["shape"].values
    np.testing.assert_allclose(rebuilt, field, atol=1e-12)


@pytest.mark.parametrize("form", ["sparse", "dense"])
@pytest.mark.parametrize("rows", [SNAPSHOTS, 12])
def test_mass_inner_product(form, rows):
    weight = weight_matrix()
    shapes, field = known_field(weight.toarray())
    result = pod(field[:rows], modes=3, mass=weight if form == "sparse" else weight.toarray())
    found = result["shape"].values
    np.testing.assert_allclose(found @ weight @ found.T, np.eye(3), atol=1e-9)
    correlation = field[:rows].T @ field[:rows] @ weight.toarray() / rows  # R W of the definition
    np.testing.assert_allclose(correlation @ found.T, found.T * result["value"].values, atol=1e-9)
    if rows == SNAPSHOTS:
        check_modes(result, shapes)


def test_small_values_keep_their_digits():
    shapes, _ = known_field()
    phase = 2 * np.pi * np.arange(SNAPSHOTS) / SNAPSHOTS
    histories = np.sqrt(2) * np.column_stack([np.cos(phase), 1e-10 * np.sin(phase)])
    values = pod(histories @ shapes[:2], modes=2)["value"].values
    assert values[1] == pytest.approx(1e-20, rel=1e-4)  # forming X^T X would leave 1e-16


def test_energy_chooses_the_number_of_modes():
    _, field = known_field()
    share = np.cumsum(HEIGHTS**2) / np.sum(HEIGHTS**2)
    assert pod(field, energy=share[0] - 1e-6).sizes["mode"] == 1
    assert pod(field, energy=share[0] + 1e-6).sizes["mode"] == 2
    assert pod(field, energy=1.0).sizes["mode"] == 3


def test_run_gives_nodal_modes_and_keeps_the_mesh(antenna_run):
    result = pod(antenna_run)
    assert result["shape"].dims == ("mode", "node", "component")
    assert result.sizes["mode"] == 1
    assert float(result["participation"][0]) == pytest.approx(1.0)
    xr.testing.assert_equal(result["triangle"], antenna_run["triangle"])


def test_dominant_shape_weighs_by_participation_and_ignores_signs():
    shapes, field = known_field()
    result = pod(field, energy=1.0)
    shape = dominant_shape(result, energy=1.0)
    share = HEIGHTS**2 / np.sum(HEIGHTS**2)
    peak = int(np.argmax(np.sum(field**2, axis=1)))
    signs = np.sign(shapes @ field[peak])
    expected = (signs * share) @ shapes
    np.testing.assert_allclose(shape, expected / expected[np.abs(expected).argmax()], atol=1e-10)
    flipped = result.assign(shape=-result["shape"], coefficient=-result["coefficient"])
    np.testing.assert_allclose(dominant_shape(flipped, energy=1.0), shape)
    assert shape.attrs["modes"] == 3
    assert dominant_shape(result, energy=0.5).attrs["modes"] == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"data": np.zeros((5, 4))}, "zero"),
        ({"data": np.ones(5)}, "shape"),
        ({"data": xr.Dataset()}, "displacement"),
        ({"data": np.full((5, 4), np.nan)}, "finite"),
        ({"data": np.ones((5, 4)), "modes": 0}, "modes"),
        ({"data": np.ones((5, 4)), "energy": 1.5}, "energy"),
        ({"data": np.ones((5, 4)), "mass": np.eye(3)}, "mass"),
        ({"data": np.ones((5, 4)), "mass": -np.eye(4)}, "positive definite"),
        ({"data": np.ones((5, 4)), "mass": np.triu(np.ones((4, 4)))}, "symmetric"),
    ],
)
def test_bad_input_is_named(arguments, words):
    with pytest.raises(InputError, match=words):
        pod(**arguments)


def test_dominant_shape_asks_for_more_modes():
    result = pod(known_field()[1], modes=1)
    with pytest.raises(InputError, match="energy"):
        dominant_shape(result, energy=0.9999)
