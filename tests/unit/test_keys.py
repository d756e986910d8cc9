"""The case-file reference: complete, true to the classes, and the same in the docs."""

from __future__ import annotations

import dataclasses
import json
import tomllib
from pathlib import Path

import pytest

import tautflex as tf
from tautflex.case import Damping, Input, Maneuver, Reduction, Solver, template
from tautflex.case.help.docstrings import field_texts, short, unit
from tautflex.case.help.reference import markdown, reference
from tautflex.case.sections.control import Actuator, Controller, Sensor
from tautflex.cli import main

M2_TEMPLATE, CONTROL_TEMPLATE = template("m2-nearest-node"), template("control")

PAGE = Path(__file__).parents[2] / "docs" / "case.md"


def test_the_page_of_the_docs_is_current():
    assert PAGE.read_text(encoding="utf-8") == markdown(reference()), "run `make reference`"


def test_every_key_of_the_template_is_listed():
    listed: dict[str, set[str]] = {}
    for entry in reference():
        section = entry.title.split("]")[0].strip("[").removesuffix(".NAME")
        listed.setdefault(section, set()).update(key.name for key in entry.keys)
    for section, given in [*tomllib.loads(M2_TEMPLATE).items(), *tomllib.loads(CONTROL_TEMPLATE).items()]:
        named = section in ("actuators", "sensors")
        for table in given.values() if named else [given] if isinstance(given, dict) else []:
            assert set(table) - {"kind", "method"} <= listed[section]


@pytest.mark.parametrize("section", [Maneuver, Damping, Solver, Input, Reduction, Sensor, Controller, Actuator])
def test_every_field_of_every_class_is_a_key_with_a_meaning(section):
    for kind, cls in section.registry.items():
        keys = section.of_kind(kind).model_fields
        wanted = {field.name for field in dataclasses.fields(cls)} - set(section.of_kind(kind).omitted_fields)
        wanted -= set(section.unused_fields(cls))
        assert wanted <= set(keys)
        assert wanted <= set(field_texts(cls)), f"{cls.__name__}: a field without words in the docstring"
        assert all(field.description and field.examples for field in keys.values())


def test_commands_print_it(capsys):
    assert main(["keys", "maneuver", "--json"]) == 0
    (stop,) = [
        entry for entry in json.loads(capsys.readouterr().out)["sections"] if entry["title"].endswith('kind = "stop"')
    ]
    duration = next(key for key in stop["keys"] if key["name"] == "duration")
    assert (duration["unit"], duration["range"], duration["default"]) == ("s", "> 0", "needed")
    assert main(["keys", "membrane", "--json"]) == 0
    (film,) = json.loads(capsys.readouterr().out)["sections"]
    assert {key["unit"] for key in film["keys"]} == {"m", "Pa", "kg/m^3", ""}, "[[membrane.layers]] is no unit"
    assert main(["keys", "cables", "--json"]) == 0
    (cables,) = json.loads(capsys.readouterr().out)["sections"]
    assert cables["keys"][0]["range"] == ">= 2", "of two limits the narrower one"
    assert main(["keys", "solver"]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert 'method = "wilson-theta"' in printed
    assert "Collocation parameter" in printed
    assert main(["keys", "--markdown"]) == 0
    assert capsys.readouterr().out == PAGE.read_text(encoding="utf-8")
    assert main(["keys", "soler"]) == 2
    assert "expected one of 'membrane'" in " ".join(capsys.readouterr().err.split())


def test_ranges_of_case_and_class_are_the_same():
    """Today's examples of the two saying different things: theta of Wilson's method, threshold of the modal basis."""
    assert Solver(theta=3.0).build() == tf.WilsonTheta(3.0)
    assert Reduction(threshold=0.0).build() == tf.ModalBasis(threshold=0.0)
    for make in (lambda: Solver(theta=3.1), lambda: tf.WilsonTheta(3.1)):
        with pytest.raises(tf.InputError, match=r"^theta: expected a number in \[1, 3\], got 3\.1; 1\.4 is"):
            make()


@pytest.mark.parametrize(
    ("text", "words", "found"),
    [
        ("Time to stop [s], > 0.", "time to stop [s], > 0", "s"),
        ("Angular velocity [rad/s] (a number [Hz]).", "angular velocity [rad/s] (a number [Hz])", "rad/s"),
        ("Coefficient of thermal expansion [1/K].", "coefficient of thermal expansion [1/K]", "1/K"),
        ("Term of the frame [paper (43)]; more.", "term of the frame [paper (43)]", ""),
        ("G, the Coriolis force.", "G, the Coriolis force", ""),
        ('"versine": a course.', "", ""),
    ],
)
def test_docstrings_become_parts_of_sentences(text, words, found):
    assert (short(text), unit(text)) == (words, found)
