"""Case keys of the time integration reach the integrator, its step and its error control."""

from __future__ import annotations

import pytest

import tautflex as tf
from tautflex import CaseError
from tautflex.case.registry import METHODS
from tautflex.case.sections.dynamic import Damping, Solver


@pytest.mark.parametrize("name", METHODS)
def test_every_method_can_be_named_in_a_case(name):
    method = Solver(method=name).build()
    assert type(method) is METHODS[name]
    assert method == METHODS[name]()


def test_new_methods_are_public():
    assert isinstance(Solver(method="energy-conserving").build(), tf.EnergyConserving)
    assert isinstance(Solver(method="central-difference").build(), tf.CentralDifference)


def test_adaptive_keys_become_error_control():
    assert Solver().adaptive() is None
    given = Solver(adaptive_tolerance=1e-3, min_step=1e-5, max_step=0.02).adaptive()
    assert given == tf.Adaptive(1e-3, 1e-5, 0.02)
    assert Solver(adaptive_tolerance=1e-3).adaptive() == tf.Adaptive(1e-3)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"adaptive_tolerance": 0.0}, "adaptive_tolerance"),
        ({"adaptive_tolerance": 0.5}, "adaptive_tolerance"),
        ({"min_step": 1e-5}, "add adaptive_tolerance"),
        ({"max_step": 1e-2}, "add adaptive_tolerance"),
        ({"adaptive_tolerance": 1e-3, "min_step": 1e-2, "max_step": 1e-3}, "min_step.*max_step"),
        ({"adaptive_tolerance": 1e-3, "max_step": 1e-9}, "max_step"),
        ({"adaptive_tolerance": 1e-3, "method": "central-difference"}, "implicit method"),
        ({"theta": 1.4, "method": "energy-conserving"}, "set method = 'wilson-theta'"),
    ],
)
def test_contradictions_are_named(keys, words):
    with pytest.raises(CaseError, match=words):
        Solver(**keys)


@pytest.mark.parametrize(
    ("keys", "meant"),
    [
        ({}, tf.Rayleigh()),
        ({"alpha": 0.1}, tf.Rayleigh(0.1)),
        ({"kind": "rayleigh", "beta": 1e-3}, tf.Rayleigh(0.0, 1e-3)),
        ({"kind": "modal", "ratio": 0.01}, tf.Modal(0.01)),
        ({"kind": "modal", "ratio": 0.01, "modes": 4}, tf.Modal(0.01, 4)),
        ({"kind": "modal", "ratio": [0.01, 0.02]}, tf.Modal((0.01, 0.02))),
    ],
)
def test_each_damping_can_be_stated_in_a_case(keys, meant):
    section = Damping(**keys)
    assert section.build() == meant
    assert Damping(**section.model_dump(exclude_none=True)) == section


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"kind": "viscous"}, r"kind: expected one of 'rayleigh' or 'modal', got 'viscous'"),
        ({"kind": "modal"}, r"ratio: missing, kind = 'modal' expects the ratio of critical damping"),
        ({"kind": "modal", "ratio": 2.0}, r"ratio: expected a number in \[0, 1\], got 2\.0"),
        ({"kind": "modal", "ratio": "much"}, r"^ratio: expected a number, got 'much'"),
        ({"ratio": 0.01}, r"ratio: expected no value with kind = 'rayleigh', got 0\.01; .* set kind = 'modal'"),
        ({"alpha": -1.0}, r"alpha: expected a number >= 0, got -1\.0; write the mass factor"),
    ],
)
def test_dampings_out_of_range_are_named(keys, words):
    with pytest.raises(CaseError, match=words):
        Damping(**keys)
