"""What sections lack is told in the same answer as keys that are wrong."""

from __future__ import annotations

import pytest

import tautflex as tf
from tautflex.case.options import by_keys

FILM = {
    "length": 2.0, "width": 1.0, "thickness": 1e-4, "youngs_modulus": 3.5e9, "poisson_ratio": 0.34, "density": 1530.0,
}  # fmt: skip
FIXED = FILM | {"edges": "fixed", "stress_x": 4e3, "stress_y": 4e3}
FRAME = ("area", "inertia_y", "inertia_z", "torsion_constant", "youngs_modulus", "poisson_ratio", "density")


def keys_of(**sections):
    """Keys that a case is refused for."""
    with pytest.raises(tf.CaseError) as caught:
        tf.Case(schema=1, **sections)
    return [problem.partition(":")[0] for problem in caught.value.problems]


def test_all_that_an_antenna_lacks_is_told_beside_wrong_keys():
    film = {"length": 2.0, "widht": 1.0, "thickness": -1e-4, "poisson_ratio": 0.34}
    cables = {"per_long_edge": 11, "youngs_modulus": "x", "area": 3e-6, "pretension_x": 1.0}
    told = keys_of(membrane=film, cables=cables, frame={"length": 2.5, "wdith": 1.5, "foo": 2})
    wrong = ["membrane.widht", "membrane.thickness", "cables.youngs_modulus", "frame.wdith", "frame.foo"]
    lacking = ["membrane.youngs_modulus", "membrane.density", "cables.per_short_edge", "cables.density"]
    lacking += ["cables.pretension_y", *(f"frame.{key}" for key in FRAME)]
    assert told[:5] == wrong
    assert sorted(told[5:]) == sorted(lacking)  # but for width, which is misspelt


def test_sections_that_are_missing_are_told_beside_wrong_keys():
    assert keys_of(membrane=FILM | {"bogus": 1}) == ["membrane.bogus", "cables", "frame"]
    assert keys_of(membrane=FILM | {"edges": "cabels"}) == ["membrane.edges"]  # what it needs is not known
    assert keys_of(membrane=FIXED | {"bogus": 1}) == ["membrane.bogus"]
    assert keys_of(membrane={"bogus": 1}, mesh={"file": "a.msh"}, cables={"bogus": 1}) == [
        "membrane.bogus",
        "cables.bogus",
    ]


def test_all_that_a_hub_lacks_is_told_with_what_its_class_refuses():
    assert keys_of(membrane=FIXED, hub={"mass": -3.0}) == ["hub.inertia", "hub.mass"]
    assert keys_of(membrane=FIXED, hub={"bogus": 1}) == ["hub.bogus", "hub.mass", "hub.inertia"]


def test_arguments_of_runs_are_told_by_the_keys_that_set_them():
    with pytest.raises(tf.InputError) as caught, by_keys():
        raise tf.InputError("time_step: expected less", "method: expected another", "interval: expected", "probes: no")
    told = [problem.partition(":")[0] for problem in caught.value.problems]
    assert told == ["solver.time_step", "solver.method", "loop.interval", "probes"]
