"""Linear view of structures: against nonlinear runs of small motion, statics, spinning modes, conservation laws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.io import loadmat
from scipy.signal import lsim

import tautflex as tf
from tautflex.case import parse_case, template
from tautflex.control.authority import authority
from tautflex.control.linearize import linearize
from tautflex.control.sensors.attitude import Attitude
from tautflex.control.sensors.cable_tension import CableTensionSensor
from tautflex.control.sensors.displacement import Displacement
from tautflex.control.sensors.modal_coordinates import ModalCoordinates
from tautflex.control.sensors.rate import Rate
from tautflex.control.sensors.sensor import SensedMotion
from tautflex.control.sensors.surface_rms import SurfaceRms
from tautflex.control.sensors.velocity import Velocity
from tautflex.control.steady import steady_state
from tautflex.mechanics.loads.inputs import InputSet
from tautflex.numeric import one_thread
from tautflex.reduction.inputs import ReducedInputs
from tautflex.solvers.linear.eigenpairs import lowest_eigenpairs
from tautflex.structure.antenna import AntennaLayout, build_fixed_film
from verification.builders import FILM, THICKNESS, antenna

pytestmark = pytest.mark.slow

A = (0.7, 0.4)
DAMPING = tf.Rayleigh(0.05, 1e-3)
STEP, END = 2e-3, 1.2


@pytest.fixture(scope="module")
def state():
    return tf.solve_prestress(antenna((0.6, 0.5), (8, 4)))


@pytest.fixture(scope="module")
def node(state):
    return int(np.argmin(np.linalg.norm(state.model.nodes - [0.5, 0.25, 0.0], axis=1)))


def fixed_film():
    layout = AntennaLayout(1.0, 0.8, (8, 6), "alternating")
    model = build_fixed_film(layout, tf.MembraneSection(FILM, THICKNESS), (4e3, 4e3, 0.0))
    return tf.solve_prestress(model)


def stepped(plant, command):
    """Outputs at all instants under a constant command."""
    d, x, outputs = plant.discretize(STEP), np.zeros(len(plant.A)), []
    for _ in range(round(END / STEP) + 1):
        outputs.append(d.C @ x + d.D @ command)
        x = d.A @ x + d.B @ command
    return np.array(outputs)


def difference(found, expected):
    return float(np.abs(found - expected).max() / np.abs(expected).max())


def test_small_motion_of_the_full_model(state, node, verification_row, tmp_path):
    """Exported too: what python-control and SciPy make of the matrices is the motion of the nonlinear model."""
    control = pytest.importorskip("control")
    force = np.array([0.0, 0.0, 1e-7])
    inputs = {"push": tf.NodalForce([node], force).prepare(state.system)}
    sensors = {"A": Displacement(A), "dA": Velocity(A)}
    run = tf.simulate(
        state, inputs=[tf.NodalForce([node], force)], probes={"A": A}, method=tf.GeneralizedAlpha(1.0), damping=DAMPING,
        time_step=STEP, end_time=END,
    )  # fmt: skip
    expected, errors = run.data["w"].values.ravel(), {}
    for modes in (10, 60):
        plant = linearize(state, inputs, sensors, damping=DAMPING, modes=modes)
        found = stepped(plant, force)
        errors[modes] = difference(found[:, 0], expected)
        late = found[2:-1, 1]
        slope = (found[3:, 0] - found[1:-2, 0]) / (2.0 * STEP)
        assert difference(late, slope) < (1.0 if modes == 10 else 0.2)
    verification_row("Linear view, point A under a small force", 0.0, errors[60], "nonlinear full model, relative")
    assert errors[60] < 0.01 < errors[10]
    times = STEP * np.arange(len(expected))
    given = np.repeat(force[:, None], len(times), axis=1)
    answer = control.forced_response(plant.to_control(), times, given)
    matrices = loadmat(plant.to_mat(tmp_path / "antenna.mat"), simplify_cells=True)
    _, written, _ = lsim(tuple(matrices[name] for name in "ABCD"), given.T, times)
    for name, found in (("python-control", answer.outputs[0]), ("the MATLAB file", written[:, 0])):
        error = difference(found, expected)
        verification_row(f"Point A by {name}", 0.0, error, "nonlinear full model, relative")
        assert error < 0.01


def test_static_answers_need_no_modes(state, node):
    """Static correction: displacements and cable tensions under held inputs are exact with any number of modes."""
    inputs = {
        "push": tf.NodalForce([node], (0.0, 0.0, 0.0)).prepare(state.system),
        "tension": tf.CableTension(cables=range(5)).prepare(state.system),
    }
    sensors = {"A": Displacement(A), "u": Displacement(A, "u"), "cables": CableTensionSensor([0, 3, 9])}
    few, many = (linearize(state, inputs, sensors, modes=modes) for modes in (1, 40))
    gains = [one.D - one.C @ np.linalg.solve(one.A, one.B) for one in (few, many)]
    np.testing.assert_allclose(gains[0], gains[1], rtol=1e-6, atol=1e-9 * np.abs(gains[1]).max())
    # The tension of five cables by a newton's hundredth each: what is left of it where film and frame give way.
    u, system = 1e-5, state.system
    change = {index: columns @ np.full(5, u) for index, columns in inputs["tension"].columns.items()}
    stressed = system.with_initial_stress(
        [stress + change.get(index, 0.0) for index, stress in enumerate(system.initial_stress)]
    )
    q = tf.solve_static(replace(state, system=stressed))
    motion = SensedMotion(q, np.zeros_like(q), np.zeros(3), np.zeros(3), stressed.stress(q))
    for name, rows in (("u", slice(1, 2)), ("cables", slice(2, 5))):
        reading = sensors[name].prepare(state).read(motion) - few.level[rows]
        np.testing.assert_allclose(gains[0][rows, 3:].sum(axis=1) * u, reading, rtol=1e-4)
    np.testing.assert_allclose(few.level[2:], state.cable_tension[[0, 3, 9]], rtol=1e-12)


def test_torque_on_a_free_hub(state, verification_row):
    """Six free directions, the structure off the hub's centre of mass: translations drop out by momentum."""
    torque = (1e-5, 2e-5, 1e-5)
    hub = tf.FreeHub(mass=20.0, inertia=(4.0, 5.0, 6.0), center=(0.1, -0.05, 0.2), torque=torque)
    wrench = {"torque": np.concatenate([np.zeros((3, 3)), np.eye(3)])}
    sensors = {"attitude": Attitude(), "rate": Rate(), "A": Displacement(A)}
    plant = linearize(state, wrench, sensors, hub=hub, damping=DAMPING)
    assert (plant.axes, plant.states[:3], plant.input_units) == (3, ("theta_x", "theta_y", "theta_z"), ("N m",) * 3)
    found = stepped(plant, np.array(torque))
    run = tf.simulate(
        state, hub, probes={"A": A}, method=tf.GeneralizedAlpha(1.0), damping=DAMPING, time_step=STEP, end_time=END
    )
    attitude = 2.0 * run.data["attitude"].values[:, 1:]
    errors = {
        "attitude": difference(found[:, :3], attitude),
        "rate": difference(found[:, 3:6], run.data["angular_velocity"].values),
        "A": difference(found[:, 6], run.data["w"].values.ravel()),
    }
    for name, error in errors.items():
        verification_row(f"Linear view on a free hub under a small torque, {name}", 0.0, error, "nonlinear, relative")
    assert max(errors["attitude"], errors["rate"]) < 1e-4
    assert errors["A"] < 0.01


class OneAxis(tf.FreeHub):
    """Hub that turns about x alone."""

    def __post_init__(self):
        super().__post_init__()
        object.__setattr__(self, "axes", "x")


def test_hub_of_one_axis_is_one_that_cannot_do_anything_else(state):
    heavy = tf.FreeHub(mass=1e10, inertia=(5.0, 1e10, 1e10))
    alone = OneAxis(mass=20.0, inertia=(5.0, 6.0, 7.0))
    wrench, sensors = {"torque": np.eye(6)[:, 3:4]}, {"attitude": Attitude(), "A": Displacement(A)}
    free, one = (linearize(state, wrench, sensors, hub=hub, damping=DAMPING, modes=20) for hub in (heavy, alone))
    assert (one.axes, one.outputs) == (1, ("attitude", "A"))
    s = 2j * np.pi * np.array([0.3, 1.1, 3.0])

    def answers(plant, outputs, command):
        resolvents = [np.linalg.solve(x * np.eye(len(plant.A)) - plant.A, plant.B) for x in s]
        return [(plant.D + plant.C @ each)[outputs, command] for each in resolvents]

    np.testing.assert_allclose(answers(one, [0, 1], 0), answers(free, [0, 3], 0), rtol=1e-6)
    rigid = one.B[21:22, 0] + one.A[21:22, 1:21] @ np.linalg.solve(-one.A[22:, 1:21], one.B[22:, 0])
    total = 5.0 + state.system.inertia.second_moment[[1, 2], [1, 2]].sum()
    assert 1.0 / rigid[0] == pytest.approx(total, rel=1e-9)


def test_wrench_of_forces_on_film_and_supports_turns_the_hub(state, node):
    """The rigid part of a force at a point is its torque about the origin, wherever it acts."""
    hub = OneAxis(mass=20.0, inertia=(5.0, 6.0, 7.0))
    corner = int(np.argmax(state.model.nodes @ [1.0, 1.0, 0.0]))
    inputs = {
        "film": tf.NodalForce([node], (0.0, 0.0, 0.0)).prepare(state.system),
        "corner": tf.NodalForce([corner], (0.0, 0.0, 0.0)).prepare(state.system),
    }
    plant = linearize(state, inputs, {"rate": Rate()}, hub=hub, modes=20)
    torques = (_mass(state, hub, plant) @ plant.B[21:])[0]
    expected = [state.model.nodes[node, 1], state.model.nodes[corner, 1]]
    np.testing.assert_allclose(torques[[2, 5]], expected, rtol=1e-9)


def _mass(state, hub, plant):
    """Mass matrix of rotation and modes, from the inertia operator."""
    inertia, (_, vectors) = state.system.inertia, state.linear.modes(plant.coordinates)
    turn = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    coupled = vectors @ inertia.load(turn)
    total = hub.tensor[0, 0] + inertia.second_moment[[1, 2], [1, 2]].sum()
    return np.block([[np.array([[total]]), coupled[None]], [coupled[:, None], np.eye(plant.coordinates)]])


def test_poles_about_a_spin_are_the_spinning_modes(state):
    motion = tf.Stop(0.6, 1.0).start()
    plant = linearize(state, {}, {}, motion=motion, damping=DAMPING, modes=40)
    expected = tf.solve_spinning_modes(state, (0.6, 0.0, 0.0), n=4, damping=DAMPING).eigenvalues
    poles = plant.poles[plant.poles.imag > 0.0]
    found = np.sort_complex(1j * poles[np.argsort(np.abs(poles))[:4]]) / 1j
    np.testing.assert_allclose(found[np.argsort(np.abs(found))], expected, rtol=2e-6)


def test_spinning_hub_keeps_its_momentum():
    """Momentum of small motion, J0 domega + B eta' + J' eta omega0, is a left null vector of A."""
    spin, state = 0.4, tf.solve_prestress(antenna((0.6, 0.5), (4, 2)))
    hub = OneAxis(mass=20.0, inertia=(5.0, 6.0, 7.0), angular_velocity=(spin, 0.0, 0.0))
    plant = linearize(state, {"torque": np.eye(6)[:, 3:4]}, {"A": Displacement(A)}, hub=hub, modes=state.system.size)
    about = steady_state(state, [], None, hub, None, None)
    mass, link = about.blocks
    # Modes are those about the steady spin, found again up to their signs by their own pencil.
    with one_thread():
        vectors = lowest_eigenpairs(
            state.system.pattern, about.stiffness, state.system.inertia.mass_entries, state.system.size
        )[1]
    momentum = np.concatenate([[0.0], -2.0 * spin * vectors @ about.swing, mass[0], vectors @ link[0]])
    change = momentum @ plant.A
    assert np.abs(change).max() < 1e-8 * np.abs(np.abs(momentum) @ np.abs(plant.A)).max()
    assert momentum @ plant.B[:, 0] == pytest.approx(1.0, rel=1e-9)
    assert np.abs(2.0 * spin * vectors @ about.swing).max() > 1e-6  # there is something to keep


def test_stiffness_under_held_tension(state):
    """Twice the difference of squared frequencies under plus and minus a tension is what the bilinear matrix says."""
    cable = {"tension": tf.CableTension().prepare(state.system)}
    count, u = len(state.cable_tension), 1e-4
    up, down = (linearize(state, cable, {}, values={"tension": sign * u}, modes=6) for sign in (1.0, -1.0))
    slope = (np.diag(up.stiffness) - np.diag(down.stiffness)) / (2.0 * u)
    rest = linearize(state, cable, {}, modes=6)
    np.testing.assert_allclose(np.einsum("kii->i", rest.bilinear), slope, rtol=1e-4)
    assert len(rest.inputs) == count
    assert all("no linear column" in text or "in the plane" in text for text in rest.remarks.values())


def test_heated_film_between_fixed_edges(verification_row):
    """Stress falls by E alpha/(1 - nu) per kelvin, and all squared frequencies with it."""
    state = fixed_film()
    heat = {"heat": tf.MembraneTemperature(0.0, 2e-5).prepare(state.system)}
    data = authority(state, heat, limits={"heat": 0.02}, modes=5)
    expected = -0.02 * FILM.youngs_modulus * 2e-5 / (1.0 - FILM.poisson_ratio) / 4e3
    np.testing.assert_allclose(data["stiffness"].values, expected, rtol=1e-6)
    verification_row("Stiffness of a film's mode 1 by 0.02 K", expected, float(data["stiffness"][0, 0]), "closed form")
    assert not data["force"].values.any()
    assert np.isnan(data["stroke"].values).all()
    with pytest.raises(tf.InputError, match="inputs: expected at least one that acts on the structure, got none"):
        authority(state, {})  # as of a plant whose only actuators are wheels
    assert "heat: no linear column on these modes" in data.attrs["remarks"]
    about = linearize(state, heat, {}, values={"heat": 0.02}, modes=3)
    np.testing.assert_allclose(
        np.diag(about.stiffness), (1.0 + expected) * np.diag(linearize(state, heat, {}, modes=3).stiffness), rtol=1e-6
    )


def test_authority_of_forces_and_hard_cables(state, node):
    inputs = {
        "push": tf.NodalForce([node], (0.0, 0.0, 0.0)).prepare(state.system),
        "cables": tf.CableTension(cables=range(3)).prepare(state.system),
    }
    data = authority(state, inputs, limits={"push": 1e-3, "cables": 0.01}, modes=4)
    modes = tf.solve_modes(state, n=4)
    shape = np.abs(modes.shapes[:, node, 2])
    np.testing.assert_allclose(np.abs(data["force"].values[2]), 1e-3 * shape, rtol=1e-9)
    assert data["input"].values.tolist() == [*(f"push[{k}]" for k in range(3)), *(f"cables[{k}]" for k in range(3))]
    assert 0.0 < float(data["stroke"][3]) < 1e-5
    assert "micrometres" in data.attrs["remarks"]
    np.testing.assert_allclose(data["frequency"], modes.frequencies)


def test_prescribed_tensions_carry_the_whole_stiffness(verification_row):
    """Film and cables have no other stiffness across the film than their tension: x and y together make all of it."""
    state = tf.solve_prestress(antenna((0.6, 0.5), (8, 4)))
    groups = {axis: tf.TensionGroup(axis, share="pretension") for axis in "xy"}
    equipped = tf.equip(state, list(groups.values()))
    bound = {axis: group.prepare(equipped.system) for axis, group in groups.items()}
    whole = {axis: state.cable_tension[one.cables].max() for axis, one in bound.items()}
    data = authority(equipped, bound, limits=whole, modes=3)
    total = data["stiffness"].sum("input").values
    verification_row("Stiffness of mode 1 by the whole pretension, x and y", 1.0, float(total[0]), "no other stiffness")
    np.testing.assert_allclose(total, 1.0, rtol=2e-3)
    reeled = [np.abs(one.stroke(np.zeros(equipped.system.size), whole[axis])).max() for axis, one in bound.items()]
    assert np.all(data["stroke"].values > reeled)  # film and frame give way
    # By length, the same cables lose nearly all of it.
    by_length = {axis: tf.TensionGroup(axis, command="length").prepare(state.system) for axis in "xy"}
    short = authority(state, by_length, limits=dict.fromkeys("xy", 1e-6), modes=3)
    np.testing.assert_allclose(short["stroke"], 1e-6, rtol=1e-12)
    assert "micrometres" in short.attrs["remarks"]


def test_bilinear_matrices_are_those_of_reduced_models(state):
    """What the view finds by differences of the tangent, reduced models have by moments of stresses: in one basis."""
    rom = tf.reduce(state, tf.ModalBasis(("z", "rx")))
    bound = tf.CableTension(cables=range(4)).prepare(state.system)
    plant = linearize(rom, {"tension": bound}, {})
    given = ReducedInputs(rom, InputSet(state.system, [tf.CableTension(cables=range(4))]))
    assert np.abs(given.stiffness).max() > 1.0
    np.testing.assert_allclose(plant.bilinear, given.stiffness, rtol=0.0, atol=1e-9 * np.abs(given.stiffness).max())


@pytest.mark.parametrize(
    ("command", "tendon", "expected"),
    [("tension", None, (0.042, 0.96)), ("length", 1e-3, (0.036, 0.37)), ("length", None, (4e-4, 9e-4))],
    ids=["tension", "soft tendons", "length"],
)
def test_authority_depends_on_the_tendon(command, tendon, expected, verification_row):
    """Whole pretension of x, of y, on the lowest mode that a turn about x excites: the prototype's numbers.

    20 x 10 cells, 21 and 11 of the paper's cables; tendons in series with them leave a thousandth of their stiffness.
    """
    changes = ["mesh.divisions=[20,10]", "cables.per_long_edge=21", "cables.per_short_edge=11", "cables.area=3.14e-6"]
    case = parse_case(template("m2"), [*changes, "cables.pretension_x=0.295", "cables.pretension_y=0.55"])
    bare = tf.solve_prestress(tf.build_model(case))
    cable = case.cables.youngs_modulus * case.cables.area / 0.25
    stiffness = None if tendon is None else cable / (1.0 / tendon - 1.0)
    groups = {axis: tf.TensionGroup(axis, share="pretension", command=command, stiffness=stiffness) for axis in "xy"}
    state = tf.equip(bare, list(groups.values()))
    bound = {axis: group.prepare(state.system) for axis, group in groups.items()}
    per_unit = 1.0 if command == "tension" else cable * (tendon or 1.0)
    whole = {axis: bare.cable_tension[one.cables].max() / per_unit for axis, one in bound.items()}
    data = authority(state, bound, limits=whole, modes=10)
    turned = np.abs(tf.solve_modes(state, n=10).shapes[:, :, 2] @ bare.model.nodes[:, 1])
    mode = int(np.flatnonzero(turned > 0.1 * turned.max())[0])
    found = data["stiffness"].values[:, mode]
    for axis, one, wanted in zip("xy", found, expected, strict=True):
        verification_row(f"Stiffness by the whole pretension of {axis}, {command}, {tendon}", wanted, one, "control.md")
    np.testing.assert_allclose(found, expected, rtol=0.05)
    if command == "tension":
        assert found.sum() == pytest.approx(1.0, rel=1e-3)  # film and cables have no other stiffness


def test_reduced_model_has_the_linear_view_of_its_own_motion(state, node):
    rom, force = tf.reduce(state, tf.ModalBasis(("z", "rx"))), np.array([0.0, 0.0, 1e-7])
    inputs = {"push": tf.NodalForce([node], force).prepare(state.system)}
    plant = linearize(rom, inputs, {"A": Displacement(A), "eta": ModalCoordinates(3)}, damping=DAMPING)
    assert plant.coordinates == rom.size
    np.testing.assert_allclose(plant.stiffness, rom.coefficients.linear, atol=1e-9 * rom.coefficients.linear.max())
    run = tf.simulate(
        rom, inputs=[tf.NodalForce([node], force)], probes={"A": A}, method=tf.GeneralizedAlpha(1.0), damping=DAMPING,
        time_step=STEP, end_time=END,
    )  # fmt: skip
    assert difference(stepped(plant, force)[:, 0], run.data["w"].values.ravel()) < 1e-3


def test_what_has_no_linear_form_is_said(state, node):
    system = state.system
    with pytest.raises(tf.InputError, match=r"^inputs.p: expected a constant pattern .*no linear column.*NodalForce"):
        linearize(state, {"p": tf.Pressure(np.ones(state.model.membrane_count)).prepare(system)}, {})
    plant = linearize(state, {}, {"rms": SurfaceRms()}, modes=3)
    assert not plant.C.any()
    assert plant.remarks["rms"].startswith("a row of zeros")
    held = tf.NodalForce([int(np.argmax(state.model.nodes @ [1.0, 1.0, 0.0]))], (0.0, 0.0, 1.0)).prepare(system)
    assert "supported directions" in linearize(state, {"held": held}, {}, modes=3).remarks["held[2]"]
    free = tf.solve_prestress(antenna((0.6, 0.5), (4, 2), support="free", mode="equilibrium"), check=False)
    with pytest.raises(tf.UnsupportedError, match="expected a structure held against rigid motion"):
        linearize(free, {}, {})
    spinning = tf.FreeHub(mass=1.0, inertia=(1.0, 1.0, 1.0), angular_velocity=(0.1, 0.0, 0.0))
    with pytest.raises(tf.UnsupportedError, match="hub: expected one at rest, or of one axis"):
        linearize(state, {}, {}, hub=spinning)
    for arguments, words in (
        ({"values": {"push": 1.0}}, "values: expected one of"),
        ({"hub": spinning, "motion": tf.AtRest().start()}, "motion: expected none beside a hub"),
        ({"hub": tf.FreeHub(1.0, (1, 1, 1)), "coupling": tf.Coupling(euler=False)}, "coupling: expected all terms"),
        ({"damping": 0.1}, "damping: expected an object such as Rayleigh"),
    ):
        with pytest.raises(tf.InputError, match=words):
            linearize(state, {}, {}, **arguments)


def test_surface_rms_is_that_of_a_saddle(verification_row):
    """``w = c x y`` over 1 x 0.8 m: its plane is zero, its mean square c^2 (1/12) (0.64/12)."""
    errors = []
    for divisions in ((6, 4), (12, 8)):
        state = tf.solve_prestress(free_edges(divisions), check=False)
        x, y = state.model.nodes[:, 0], state.model.nodes[:, 1]
        full = np.zeros(state.model.dof_count)
        full[state.model.translation_dofs[:, 2]] = 1e-3 * x * y + 2e-3 + 3e-3 * x - 1e-3 * y
        q = full[state.model.free_dofs]
        motion = SensedMotion(q, np.zeros_like(q), np.zeros(3), np.zeros(3), [])
        (rms,) = SurfaceRms().prepare(state).read(motion)
        errors.append(rms / (1e-3 * np.sqrt(0.64) / 12.0) - 1.0)
    verification_row("Surface rms of a saddle, 12 x 8 cells", 0.0, abs(errors[1]), "closed form, relative")
    assert errors[0] / errors[1] > 3.5  # of second order at least
    assert abs(errors[1]) < 1e-3


def free_edges(divisions):
    """Film whose nodes all move along z, held in its plane."""
    layout = AntennaLayout(1.0, 0.8, divisions, "alternating")
    model = build_fixed_film(layout, tf.MembraneSection(FILM, THICKNESS), (4e3, 4e3, 0.0))
    return tf.Model.from_mesh(
        model.nodes,
        triangles=model.triangles,
        membrane=tf.MembraneSection(FILM, THICKNESS),
        membrane_stress=(4e3, 4e3, 0.0),
        prestress_mode="uniform",
        supports=[tf.Support(tuple(range(len(model.nodes))), ("x", "y"))],
    )
