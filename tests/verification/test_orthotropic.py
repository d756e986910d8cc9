"""Films that are not alike in all directions, and films of several layers, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import tautflex as tf
from tautflex.case import parse_case, template
from tautflex.structure.mesh import rectangle_mesh

E1, E2, NU, G = 9e9, 3e9, 0.3, 1.2e9
PLY = tf.OrthotropicMaterial(E1, 1500.0, NU, youngs_modulus_2=E2, shear_modulus_12=G)
FOIL = tf.Material(3e9, 1420.0, 0.34)
METAL = tf.Material(70e9, 2700.0, 0.33)
COAT = tf.MembraneSection(METAL, 1e-7)


def turned(angle):
    return tf.OrthotropicMaterial(E1, 1500.0, NU, youngs_modulus_2=E2, shear_modulus_12=G, angle=angle)


def pulled(material, force=10.0):
    """Strip of 0.4 x 0.1 m and 0.1 mm pulled along x: strains along and across."""
    nodes, triangles = rectangle_mesh(np.linspace(0.0, 0.4, 9), np.linspace(0.0, 0.1, 3))
    left, right = (np.flatnonzero(np.abs(nodes[:, 0] - x) < 1e-9) for x in (0.0, 0.4))
    model = tf.Model.from_mesh(
        nodes,
        triangles=triangles,
        membrane=tf.MembraneSection(material, 1e-4),
        membrane_stress=(1e3, 1e3, 0.0),
        supports=(
            tf.Support(tuple(left), ("x",)),
            tf.Support((int(left[0]),), ("x", "y", "z")),
            tf.Support(tuple(range(len(nodes))), ("z",)),
        ),
        prestress_mode="uniform",
    )
    state = tf.solve_prestress(model)
    forces = np.zeros((len(nodes), 3))
    forces[right, 0] = force * np.array([0.5, 1.0, 0.5]) / 2.0
    u = state.system.translations(tf.solve_static(state, forces=forces))
    corner = right[-1]
    return u[corner, 0] / 0.4, (u[corner, 1] - u[right[0], 1]) / 0.1


@pytest.mark.parametrize("angle", [0.0, 0.5 * np.pi, np.pi / 6])
def test_a_strip_strains_by_its_compliance_in_the_direction_of_the_pull(angle, verification_row):
    """Jones, Mechanics of Composite Materials (1999), (2.97): 1/E_x = c^4/E1 + (1/G - 2 nu/E1) s^2 c^2 + s^4/E2."""
    c, s = np.cos(angle), np.sin(angle)
    along = c**4 / E1 + (1 / G - 2 * NU / E1) * (s * c) ** 2 + s**4 / E2
    across = -(NU * (c**4 + s**4) / E1 - (1 / E1 + 1 / E2 - 1 / G) * (s * c) ** 2)
    stress = 10.0 / (0.1 * 1e-4)
    found = pulled(turned(angle))
    # The sheared strip leans; its ends stay apart by what it strains. Second order: 1e-3.
    assert found == pytest.approx((along * stress, across * stress), rel=3e-3)
    verification_row(
        f"strip at {np.degrees(angle):.0f} deg to its fibres: strain",
        f"{along * stress:.4e}",
        f"{found[0]:.4e}",
        "Jones (2.97)",
    )


def test_layers_add_up(verification_row):
    """Resultants are those of the layers under one strain."""
    foil, metal = tf.MembraneSection(FOIL, 25e-6), COAT
    both = tf.laminate(metal, foil, metal)
    assert both.thickness == pytest.approx(25.2e-6)
    assert both.mass_per_measure == pytest.approx(1420 * 25e-6 + 2700 * 2e-7)
    strain = np.array([1e-4, -3e-5, 2e-5])
    wanted = 25e-6 * FOIL.plane_stress @ strain + 2e-7 * METAL.plane_stress @ strain
    assert both.thickness * both.material.plane_stress @ strain == pytest.approx(wanted, rel=1e-12)
    assert tf.laminate(foil) is foil
    # Crossed plies are stiff alike along both, and a third as much in shear.
    crossed = tf.laminate(*(tf.MembraneSection(turned(a), 5e-5) for a in (0.0, 0.5 * np.pi))).material.plane_stress
    assert crossed[0, 0] == pytest.approx(crossed[1, 1], rel=1e-12)
    assert crossed[2, 2] == pytest.approx(G, rel=1e-12)
    assert np.abs(crossed[:2, 2]).max() < 1e-6 * G


def test_isotropic_moduli_give_the_isotropic_film():
    same = tf.OrthotropicMaterial(3e9, 1.0, 0.34, youngs_modulus_2=3e9, shear_modulus_12=3e9 / 2.68, angle=0.7)
    assert same.plane_stress == pytest.approx(FOIL.plane_stress, rel=1e-12, abs=1e-3)


def test_cases_have_coatings_and_fabrics():
    film = ["membrane.youngs_modulus_y=1.75e9", "membrane.shear_modulus=1e9", "mesh.divisions=[10, 5]"]
    cables = ["cables.per_long_edge=11", "cables.per_short_edge=6"]
    case = parse_case(
        template("m2")
        + "\n[[membrane.layers]]\nthickness = 1e-7\nyoungs_modulus = 70e9\npoisson_ratio = 0.33\ndensity = 2700.0\n",
        [*film, *cables],
    )
    state = tf.solve_prestress(tf.build_model(case))
    section = state.model.groups[0].section
    ply = tf.OrthotropicMaterial(3.5e9, 1530.0, 0.34, youngs_modulus_2=1.75e9, shear_modulus_12=1e9)
    wanted = (1e-4 * ply.plane_stress + 1e-7 * METAL.plane_stress) / section.thickness
    assert state.system.blocks[0].elasticity[0] == pytest.approx(wanted, rel=1e-12)
    assert parse_case(case.to_toml()) == case
    rom = tf.reduce(state, tf.ModalBasis(count=24))
    stop = tf.Stop(0.1, 0.1)
    records = [
        tf.simulate(plant, stop, end_time=0.2, time_step=1e-3, probes={"A": (0.2, 0.1)}).data.w.values
        for plant in (state, rom)
    ]
    assert np.linalg.norm(records[1] - records[0]) < 0.15 * np.linalg.norm(records[0])  # of 24 modes, whatever the film


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: tf.OrthotropicMaterial(1e9, 1.0, 1.2, youngs_modulus_2=1e9, shear_modulus_12=1e9), "nu_12"),
        (lambda: tf.OrthotropicMaterial(1e9, 1.0, youngs_modulus_2=-1e9, shear_modulus_12=1e9), "youngs_modulus_2"),
        (lambda: tf.MembraneSection(PLY, 1e-4, law="tension-field"), "law: expected 'elastic'"),
        (lambda: tf.CableSection(PLY, 1e-6), "isotropic"),
        (lambda: tf.laminate(), "layers: expected one or more"),
        (lambda: tf.laminate(COAT, tf.MembraneSection(FOIL, 1e-4, "green-lagrange")), "alike"),
        (lambda: parse_case(template("m2"), ["membrane.shear_modulus=1e9"]), "youngs_modulus_y: missing"),
    ],
)  # fmt: skip
def test_wrong_materials_are_refused(make, words):
    with pytest.raises(tf.InputError, match=words):
        make()
