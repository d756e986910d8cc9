"""Laws and elements from outside: what a registered class can do, and what is refused."""

from __future__ import annotations

import pickle
import subprocess
import sys
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

import tautflex as tf
from tautflex import (
    CableSection,
    Element,
    InputError,
    Law,
    LawFunction,
    Material,
    MembraneSection,
    Model,
    solve_prestress,
)
from tautflex.case.reading import parse_case, template
from tautflex.elements import LAWS, register_element, register_law
from tautflex.elements.laws import Slack, TensionField, law_of
from tautflex.mechanics.system import StructuralSystem
from tautflex.structure.materials import LAW_NAMES
from tautflex.structure.model import Support
from tautflex.structure.shapes import TRIANGLE3

M2_TEMPLATE = template("m2-nearest-node")

YARN, AREA, LIMIT = Material(2e9, 1000.0), 1e-6, 4e6


@LawFunction
def softening(stress, tangent, energy, parameters, count):
    """Stress ``limit tanh(s / limit)`` of the trial stress s; energy ``limit^2 log cosh(s / limit) / E``."""
    young, limit = parameters
    for e in range(count):
        ratio = stress[0, e] / limit
        stress[0, e] = limit * np.tanh(ratio)
        tangent[0, 0, e] = young / np.cosh(ratio) ** 2
        energy[e] = limit**2 * np.log(np.cosh(ratio)) / young


@dataclass(frozen=True)
class Softening(Law):
    """Cable that yields to its load, without memory."""

    name: ClassVar[str] = "softening"
    sections: ClassVar[tuple[str, ...]] = ("cable",)
    function: ClassVar[LawFunction | None] = softening
    limit: float = LIMIT

    def parameters(self, material: Material) -> tuple[float, ...]:
        return material.youngs_modulus, self.limit


@pytest.fixture(scope="module", autouse=True)
def _known():
    """The law is forgotten behind these tests, for those that follow in the same process."""
    names = {kind: list(known) for kind, known in LAW_NAMES.items()}
    register_law(Softening)
    yield
    LAWS.pop(Softening.name)
    LAW_NAMES.update(names)


def string(law: object, tension: float = 1.0) -> Model:
    nodes = np.column_stack([np.linspace(0.0, 1.0, 5), np.zeros(5), np.zeros(5)])
    return Model.from_mesh(
        nodes,
        cables=np.column_stack([np.arange(4), np.arange(1, 5)]),
        cable=CableSection(YARN, AREA, "green-lagrange", law=law),
        cable_tension=tension,
        supports=[Support.pinned([0, 4])],
    )


@pytest.mark.parametrize("law", ["softening", Softening(), Softening(limit=1e6)], ids=["name", "law", "option"])
def test_law_from_outside_in_the_kernel(law):
    limit = law.limit if isinstance(law, Softening) else LIMIT
    system = StructuralSystem.from_model(string(law))
    q = 1e-3 * np.random.default_rng(0).standard_normal(system.size)
    (stress,), (force, energy) = system.stress(q), system.force(q)
    nodes = np.concatenate([np.zeros(3), q, np.zeros(3)]).reshape(5, 3) + system.model.nodes
    stretch = np.sum(np.diff(nodes, axis=0) ** 2, axis=1) / 0.25**2
    trial = 1.0 / AREA + YARN.youngs_modulus * 0.5 * (stretch - 1.0)
    np.testing.assert_allclose(stress[:, 0], limit * np.tanh(trial / limit), rtol=1e-10)
    steps = 1e-7 * np.eye(system.size)
    slope = [(system.force(q + step)[1] - system.force(q - step)[1]) / 2e-7 for step in steps]
    np.testing.assert_allclose(force, slope, atol=1e-6 * np.abs(force).max())
    columns = [(system.force(q + step)[0] - system.force(q - step)[0]) / 2e-7 for step in steps]
    matrix = system.matrix(system.tangent(q)).toarray()
    np.testing.assert_allclose(matrix, np.transpose(columns), atol=1e-6 * np.abs(matrix).max())
    # The average force does the work of the energy.
    start = 1e-4 * np.ones(system.size)
    work = system.workspace().average_force(start, q) @ (q - start)
    assert work == pytest.approx(energy - system.force(start)[1], rel=1e-12)


def test_tensioning_finds_the_minimum_of_a_law_that_never_gives_way():
    """A string tensioned between rigid ends at twice the limit carries the limit's share of it."""
    state = solve_prestress(replace(string("softening", 2.0 * LIMIT * AREA), prestress_mode="initial-strain"))
    np.testing.assert_allclose(state.cable_tension, LIMIT * AREA * np.tanh(2.0), rtol=1e-12)
    assert state.relative_residual < 1e-10


def test_cables_of_a_case_take_a_law_by_its_name():
    sections = [
        {group.section.kind: group.section for group in tf.build_model(parse_case(M2_TEMPLATE, given)).groups}["cable"]
        for given in (["cables.law=softening"], ["cables.law=slack"], ["cables.slack=true"])
    ]
    assert isinstance(law_of(sections[0]), Softening)
    assert [law_of(section) for section in sections[1:]] == [Slack(), Slack()]
    known = "one of 'elastic', 'slack' or 'softening'"
    with pytest.raises(tf.CaseError, match=f"cables.law: expected {known}, got 'plastic'; did you mean 'elastic'"):
        parse_case(M2_TEMPLATE, ["cables.law=plastic"])
    both = parse_case(M2_TEMPLATE, ["cables.law=softening", "cables.slack=true"])
    with pytest.raises(tf.CaseError, match=r"cables\.slack: expected False with a law of its own, got True"):
        tf.build_model(both)


def test_shares_walk_through_the_law():
    assert Softening().with_share(0.5) == Softening()
    assert (Softening().share, Slack().share) == (0.0, 1e-7)
    assert TensionField().with_share(0.5).share == 0.5
    point = Slack.function.at(np.array([-2.0]), Slack(0.25).parameters(Material(4.0, 1.0)))
    assert (point.stress[0], point.tangent[0, 0], point.energy) == (-0.5, 1.0, 0.125)


def test_law_written_in_a_session_needs_no_file():
    space: dict = {}
    exec("def law(stress, tangent, energy, parameters, count):\n    energy[0] = parameters[0]\n", space)
    assert LawFunction(space["law"]).at(np.zeros(1), (3.0,)).energy == 3.0


@pytest.mark.slow
def test_state_with_laws_goes_to_another_process(tmp_path):
    """Machine code has other addresses there: a state takes none along."""
    state = solve_prestress(string("slack"))
    q = np.full(state.system.size, 1e-3)
    (tmp_path / "state").write_bytes(pickle.dumps((state, q)))
    code = "import pickle, sys; s, q = pickle.load(open(sys.argv[1], 'rb')); print(s.system.force(q)[1].hex())"
    asked = [sys.executable, "-c", code, str(tmp_path / "state")]
    answer = subprocess.run(asked, check=True, capture_output=True, text=True, timeout=120).stdout
    assert float.fromhex(answer.strip()) == state.system.force(q)[1]


def test_what_is_no_law_or_element_is_refused():
    with pytest.raises(InputError, match=r"law: expected one of 'elastic', 'slack', 'softening'.*got 'plastic'"):
        CableSection(YARN, AREA, law="plastic")
    with pytest.raises(
        InputError, match=r"law: expected a law for a membrane \(by name: elastic, tension-field.*Softe"
    ):
        solve_prestress(
            Model.from_mesh(
                [[0, 0, 0], [1, 0, 0], [0, 1, 0]],
                triangles=[[0, 1, 2]],
                membrane=MembraneSection(YARN, 1e-4, law=Softening()),
                membrane_stress=(1.0, 1.0, 0.0),
            )
        )
    with pytest.raises(InputError, match=r"slack: expected False with a law of its own, got True"):
        CableSection(YARN, AREA, slack=True, law="softening")
    with pytest.raises(InputError, match=r"law: expected a subclass of tautflex.Law with a name, got <class 'int'>"):
        register_law(int)

    class Other(Law):
        name = "slack"

    with pytest.raises(InputError, match=r"law: expected a new name, got 'slack', which Slack has; rename it"):
        register_law(Other)
    assert LAWS["slack"] is Slack

    class Second(Element):
        kind, shape = "membrane", TRIANGLE3

    with pytest.raises(InputError, match=r"element: expected a new membrane shape, Triangle3 has 'triangle3'"):
        register_element(Second)
    with pytest.raises(InputError, match=r"element: expected a subclass of tautflex.Element, got 'triangle9'"):
        register_element("triangle9")
