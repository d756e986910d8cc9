import numpy as np
import pytest

from tautflex import InputError, mac, mac_table


def test_scaled_shape_is_the_same_shape():
    shapes = np.random.default_rng(0).standard_normal((3, 20))
    np.testing.assert_allclose(np.diag(mac(shapes, shapes * [[-4.0], [1e-9], [1e9]])), 1.0)


@pytest.mark.parametrize("angle", [0.0, 0.3, 1.0, np.pi / 2])
def test_rotated_shape_gives_the_squared_cosine(angle):
    a, b = np.linalg.qr(np.random.default_rng(1).standard_normal((12, 2)))[0].T
    assert mac(a, np.cos(angle) * a + np.sin(angle) * b)[0, 0] == pytest.approx(np.cos(angle) ** 2, abs=1e-12)


def test_nodal_and_flat_shapes_agree(antenna_modes):
    nodal = antenna_modes["shape"].values
    flat = nodal.reshape(len(nodal), -1)
    expected = mac(flat, flat)
    near = {"rtol": 1e-12, "atol": 1e-12}
    np.testing.assert_allclose(mac(nodal, nodal), expected, **near)
    np.testing.assert_allclose(mac(antenna_modes["shape"], nodal), expected, **near)
    np.testing.assert_allclose(mac(nodal[2], nodal), expected[[2]], **near)
    one = antenna_modes["shape"].isel(mode=2)
    np.testing.assert_allclose(mac(one, antenna_modes["shape"]), expected[[2]], **near)


def test_table_ranks_a_known_mixture(antenna_modes):
    flat = antenna_modes["shape"].values.reshape(6, -1)
    orthonormal = np.linalg.qr(flat.T)[0].T.reshape(antenna_modes["shape"].shape)
    modes = antenna_modes.assign(shape=(antenna_modes["shape"].dims, orthonormal))
    mixture = 0.9 * orthonormal[3] + 0.4 * orthonormal[0] - 0.1 * orthonormal[5]
    table = mac_table(mixture, modes, count=3)
    parts = np.array([0.81, 0.16, 0.01]) / 0.98
    assert table["mode"].values.tolist() == [4, 1, 6]
    np.testing.assert_allclose(table["mac"], parts, rtol=1e-10)
    np.testing.assert_allclose(table["cumulative"], np.cumsum(parts), rtol=1e-10)
    np.testing.assert_allclose(table["frequency"], [1.9923, 1.0005, 2.1286])


def test_shapes_that_do_not_fit_are_refused(antenna_modes):
    with pytest.raises(InputError, match="same nodes"):
        mac(np.ones((2, 6)), np.ones((2, 9)))
    with pytest.raises(InputError, match="not zero"):
        mac(np.ones(6), np.zeros(6))
    with pytest.raises(InputError, match="count"):
        mac_table(antenna_modes["shape"][0], antenna_modes, count=0)
    with pytest.raises(InputError, match="shape"):
        mac_table(antenna_modes["shape"][0], antenna_modes.drop_vars("shape"))
