import numpy as np
import pytest
import xarray as xr

from tautflex import InputError, NotWrittenError
from tautflex.files import netcdf
from unit.full_disk import files_no_longer_than


def dataset():
    attributes = {
        "title": "M2 ω₀ = π/5",
        "case": "schema = 1\n[membrane]\nlength = 2.0\n",
        "empty": "",
        "tricky": "json:true",
        "converged": True,
        "limit": None,
        "steps": 10001,
        "time_step": 1e-3,
        "single": [1.0],
        "names": ["A", "B"],
        "nested": {"theta": 1.4, "axis": [1, 0, 0]},
    }
    return xr.Dataset(
        {
            "w": (
                ("time", "probe"),
                np.array([[1e-3, np.nan], [np.pi, -np.inf], [0.1, 5e-324]]),
                {"units": "m", "long_name": "transverse displacement", "nodal": False, "source": None},
            ),
            "duration": ("probe", [1.0, 2.0], {"units": "seconds"}),  # must not become a time difference
            "triangle": (("triangle", "corner"), np.arange(6).reshape(2, 3), {"units": "1"}),
            "cable": (("cable", "end"), np.zeros((0, 2), dtype=np.int64), {"units": "1"}),
            "symmetry": ("mode", np.array(["SA", "--"])),
            "slack": ("mode", np.array([True, False])),
            "single": ("mode", np.array([1, 2], dtype=np.float32)),
            "total": ((), 3.5, {"units": "kg"}),
        },
        {
            "time": ("time", [0.0, 1e-3, 2e-3], {"units": "s", "long_name": "time"}),
            "probe": ("probe", ["A", "point B"], {"long_name": "probe"}),
        },
        attributes,
    )


def test_round_trip_is_exact(tmp_path):
    before = dataset()
    back = netcdf.load(netcdf.save(before, tmp_path / "deep" / "run.nc"))
    xr.testing.assert_identical(back, before)
    for name in before.variables:
        assert back[name].dtype == before[name].dtype, name
    assert back.attrs["converged"] is True
    assert back.attrs["limit"] is None
    assert type(back.attrs["steps"]) is int


def test_saving_leaves_the_dataset_alone_and_can_replace(tmp_path):
    before = dataset()
    path = netcdf.save(before, tmp_path / "run.nc")
    xr.testing.assert_identical(before, dataset())
    netcdf.save(before.assign_attrs(title="again"), path)
    assert netcdf.load(path).attrs["title"] == "again"
    assert [item.name for item in tmp_path.iterdir()] == ["run.nc"]


@pytest.mark.parametrize("size", [0, 7, 500, 2000, 4000, 8000])
def test_failed_write_keeps_the_old_file(tmp_path, size):
    path = netcdf.save(dataset(), tmp_path / "run.nc")
    with files_no_longer_than(size), pytest.raises(NotWrittenError, match=r"run\.nc.*File too large"):
        netcdf.save(xr.Dataset({"long": ("x", np.arange(1e4))}), path)
    assert [item.name for item in tmp_path.iterdir()] == ["run.nc"]
    xr.testing.assert_identical(netcdf.load(path), dataset())


def test_unreadable_files_are_named(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        netcdf.load(tmp_path / "none.nc")
    text = tmp_path / "text.nc"
    text.write_text("schema = 1\n")
    with pytest.raises(InputError, match=r"text\.nc"):
        netcdf.load(text)
    whole = netcdf.save(dataset(), tmp_path / "run.nc").read_bytes()
    (tmp_path / "cut.nc").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match=r"cut\.nc"):
        netcdf.load(tmp_path / "cut.nc")
    xr.Dataset({"a": ("x", [1.0])}).to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    with pytest.raises(InputError, match="tautflex"):
        netcdf.load(tmp_path / "other.nc")


def test_newer_schema_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(netcdf, "_SCHEMA", 2)
    path = netcdf.save(dataset(), tmp_path / "run.nc")
    monkeypatch.undo()
    with pytest.raises(InputError, match="upgrade"):
        netcdf.load(path)


def test_what_cannot_be_stored_is_named(tmp_path):
    with pytest.raises(InputError, match="'odd' of w"):
        netcdf.save(xr.Dataset({"w": ((), 1.0, {"odd": object()})}), tmp_path / "a.nc")
    with pytest.raises(InputError, match="Dataset"):
        netcdf.save({"w": 1.0}, tmp_path / "a.nc")
    assert list(tmp_path.iterdir()) == []


def test_versions_name_what_the_numbers_depend_on():
    found = netcdf.versions()
    assert found["numpy"] == np.__version__
    assert {"python", "tautflex", "scipy", "numba"} <= set(found)
