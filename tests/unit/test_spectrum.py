import numpy as np
import pytest
import xarray as xr

from tautflex import InputError, amplitude, dominant_frequency, spectrum


def tones(time, *pairs):
    return sum(height * np.cos(2 * np.pi * frequency * time + 0.3) for frequency, height in pairs)


def record(values, step=1e-3, units="m"):
    time = np.arange(len(values)) * step
    return xr.DataArray(values, {"time": time}, "time", name="w", attrs={"units": units})


@pytest.mark.parametrize(
    ("count", "step", "length", "width"),
    [
        (10000, 1e-3, None, 0.0610352),  # paper, Table 7: 10 s at 1 ms in 16384 samples
        (10001, 1e-3, None, 0.0610352),
        (15625, 0.64e-3, None, 0.0953674),  # paper, Tables 6, 8, 9: 10.48576 s
        (10001, 1e-3, 10.48576, 0.0953674),  # the same bins from a record at 1 ms
    ],
)
def test_bin_widths_of_the_paper(count, step, length, width):
    time = np.arange(count) * step
    peak = dominant_frequency(record(tones(time, (2.0, 1.0)), step), length=length)
    assert peak.bin_width == pytest.approx(width, abs=5e-8)
    bins = peak.frequency / peak.bin_width
    assert bins == pytest.approx(round(bins), abs=1e-9)
    assert abs(peak.frequency - 2.0) <= 0.5 * peak.bin_width
    assert peak.interpolated == pytest.approx(2.0, abs=0.1 * peak.bin_width)


def test_published_frequency_is_the_21st_bin():
    time = np.arange(10001) * 1e-3
    peak = dominant_frequency((tones(time, (1.99, 1.0)), 1e-3), length=10.48576)
    assert round(peak.frequency, 4) == 2.0027  # paper, Table 6, M2


def test_two_tones_on_bins_show_their_amplitudes():
    time = np.arange(4096) / 1024  # 4 s, bins 0.25 Hz apart
    lines = spectrum(record(5.0 + tones(time, (3.0, 0.7), (10.25, 0.2)), 1 / 1024))
    height = lines["amplitude"]
    np.testing.assert_allclose(height.sel(frequency=[3.0, 10.25]), [0.7, 0.2], rtol=1e-12)
    assert float(height.drop_sel(frequency=[3.0, 10.25]).max()) < 1e-12
    assert height.attrs["units"] == "m"
    assert lines.attrs["bin_width"] == 0.25


@pytest.mark.parametrize("pad", ["none", "next-power-of-two"])
@pytest.mark.parametrize("count", [1000, 1001])
def test_energy_is_that_of_the_record(pad, count):
    values = np.random.default_rng(1).standard_normal(count)
    lines = spectrum((values, 0.01), pad, remove_mean=False)
    total = float(lines["energy"].sum()) * lines.attrs["bin_width"]
    assert total == pytest.approx(0.01 * np.sum(values**2), rel=1e-12)


@pytest.mark.parametrize("length", [10.24, 9.7137, 10.48576])
def test_any_length_is_the_fourier_sum_at_its_own_frequencies(length):
    values = np.random.default_rng(2).standard_normal(900)
    lines = spectrum((values, 0.01), length=length, remove_mean=False)
    frequency = np.arange(lines.sizes["frequency"]) / length
    np.testing.assert_allclose(lines["frequency"], frequency, rtol=1e-12)
    sums = np.exp(-2j * np.pi * np.outer(frequency, 0.01 * np.arange(900))) @ values
    expected = np.abs(sums[1:-1]) * 2 / 900  # both signs of the frequency
    np.testing.assert_allclose(lines["amplitude"][1:-1], expected, atol=1e-10)


def test_larger_tone_wins_and_the_maneuver_can_be_left_out():
    time = np.arange(10001) * 1e-3
    values = tones(time, (2.0, 1.0)) + 5.0 * (time < 1.0)  # a frame that decelerates for a second
    assert dominant_frequency((values, 1e-3)).frequency < 0.3
    after = dominant_frequency((values, 1e-3), after=1.0)
    assert after.frequency == pytest.approx(2.0, abs=0.5 * after.bin_width)
    # The bins stay those of the whole record: 9001 samples alone would still pad to 16384, 8001 to 8192.
    assert dominant_frequency((values, 1e-3), after=2.0).bin_width == pytest.approx(1 / 16.384, rel=1e-12)
    with pytest.raises(InputError, match="after"):
        dominant_frequency((values, 1e-3), after=9.999)


def test_constant_record_has_no_frequency():
    peak = dominant_frequency((np.full(100, 3.3), 0.1))
    assert np.isnan(peak.frequency)
    assert np.isnan(peak.interpolated)


def test_amplitude_is_the_largest_absolute_value():
    assert amplitude(record([1.0, -3.0, 2.0])) == 3.0
    assert amplitude(([1.0, -3.0, 2.0], 0.1)) == 3.0
    assert amplitude([0.5]) == 0.5


@pytest.mark.parametrize(
    ("bad", "words"),
    [
        (record(np.ones(3)), "at least 4 samples"),
        (record(np.ones(8)).assign_coords(time=[0, 1, 2, 3, 4, 5, 6, 8.0]), "constant step"),
        (record([1.0, np.nan, 1.0, 2.0, 3.0]), "finite"),
        (xr.DataArray(np.ones((5, 2)), dims=("time", "probe")), "sel"),
        (xr.DataArray(np.ones(5), dims="time"), "coordinate"),
        ((np.ones(5), 0.0), "time_step"),
        ("w", "DataArray"),
    ],
)
def test_bad_records_are_named(bad, words):
    with pytest.raises(InputError, match=words):
        spectrum(bad)


def test_padding_shorter_than_the_record_is_refused():
    with pytest.raises(InputError, match="length"):
        spectrum((np.ones(100), 0.1), length=5.0)
    with pytest.raises(InputError, match="pad"):
        spectrum((np.ones(100), 0.1), "zeros")
