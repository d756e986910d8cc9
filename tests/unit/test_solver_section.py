"""Case keys of the time integration reach the integrator, its step and its error control."""

from __future__ import annotations

import pytest

import tautflex as tf
from tautflex.case.build import build_adaptive, build_method
from tautflex.case.registry import METHODS
from tautflex.case.sections.dynamic import Solver
from tautflex.errors import CaseError


class CaseStub:
    """Only the section that these builders read."""

    def __init__(self, **keys) -> None:
        self.solver = Solver(**keys)


@pytest.mark.parametrize("name", METHODS)
def test_every_method_can_be_named_in_a_case(name):
    method = build_method(CaseStub(method=name))
    assert type(method) is METHODS[name]
    assert method == METHODS[name]()


def test_new_methods_are_public():
    assert isinstance(build_method(CaseStub(method="energy-conserving")), tf.EnergyConserving)
    assert isinstance(build_method(CaseStub(method="central-difference")), tf.CentralDifference)


def test_adaptive_keys_become_error_control():
    assert build_adaptive(CaseStub()) is None
    given = build_adaptive(CaseStub(adaptive_tolerance=1e-3, min_step=1e-5, max_step=0.02))
    assert given == tf.Adaptive(1e-3, 1e-5, 0.02)
    assert build_adaptive(CaseStub(adaptive_tolerance=1e-3)) == tf.Adaptive(1e-3)


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
