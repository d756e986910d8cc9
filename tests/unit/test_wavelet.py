import numpy as np
import pytest

from tautflex import InputError, scalogram

STEP = 5e-3
TIME = np.arange(4000) * STEP


@pytest.mark.parametrize("bandwidth", [1.5, 3.0, 6.0])
def test_tone_shows_frequency_and_amplitude(bandwidth):
    data = scalogram((0.3 * np.cos(2 * np.pi * 2.0 * TIME), STEP), bandwidth=bandwidth)
    free = (data["ridge"] > 2 * data["cone_of_influence"]).values
    assert free.sum() > 2000
    np.testing.assert_allclose(data["ridge"].values[free], 2.0, rtol=3e-3)
    np.testing.assert_allclose(data["ridge_magnitude"].values[free], 0.3, rtol=0.01)


def test_ridge_follows_a_chirp():
    start, rate = 1.0, 0.15  # [Hz], [Hz/s]: 1 to 4 Hz in 20 s
    values = np.cos(2 * np.pi * (start * TIME + 0.5 * rate * TIME**2))
    data = scalogram((values, STEP), frequencies=np.linspace(0.5, 6.0, 150))
    instantaneous = start + rate * TIME
    free = instantaneous > 1.5 * data["cone_of_influence"].values
    assert free.sum() > 2500
    np.testing.assert_allclose(data["ridge"].values[free], instantaneous[free], rtol=0.015)


def test_ridge_passes_over_a_slow_offset():
    values = 3.0 * np.exp(-((TIME - 10) ** 2) / 40) + np.cos(2 * np.pi * 3.0 * TIME)
    data = scalogram((values, STEP), frequencies=np.geomspace(0.05, 6, 100))
    middle = np.abs(TIME - 10) < 5
    np.testing.assert_allclose(data["ridge"].values[middle], 3.0, rtol=0.01)


def test_cone_and_shapes():
    data = scalogram((np.sin(TIME * 9), STEP), bandwidth=4.0, center=1.5)
    assert data["magnitude"].dims == ("frequency", "time")
    assert data["magnitude"].shape == (120, TIME.size)
    assert float(data["cone_of_influence"][400]) == pytest.approx(1.5 * 2.0 / 2.0)  # C sqrt(B) / (2 s)
    assert np.isinf(data["cone_of_influence"][[0, -1]]).all()


@pytest.mark.parametrize("frequencies", [[1.0, 2.0], [0.0, 1.0, 2.0], [3.0, 2.0, 1.0], [1.0, 2.0, 100.0]])
def test_unusable_frequencies_are_refused(frequencies):
    with pytest.raises(InputError, match="frequencies"):
        scalogram((np.sin(TIME), STEP), frequencies)
