"""Turn an antenna so that it is at rest when the turn ends: gradients find a profile that beats input shaping.

A film antenna turns by a given angle about its long axis, from rest to rest. Three profiles of the same duration, angle
and largest rate compete: bang-bang, bang-bang shaped for the loudest mode (ZVD), and a spline whose knots a gradient
method chose on the reduced model, for tensions 5 % off as well. The full nonlinear model judges.

Run ``python examples/optimal_stop.py -o FOLDER`` (needs the extra ``batch``); it prints a table and draws a figure.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize

import tautflex as tf
from tautflex import ReducedModel
from tautflex.batch import residual_energy
from tautflex.plot.style import DOUBLE_COLUMN, GREY, LINES, new_figure, save_figure, styled
from tautflex.solvers.static.prestress import PrestressedState
from tautflex.solvers.transient.simulate import Run
from tautflex.structure.antenna import AntennaLayout, build_antenna

Array = NDArray[np.float64]

PROBE = {"A": (0.7036, 0.4267)}
DAMPING = tf.Rayleigh(0.001, 0.001)
# Factors of the tension for which the profile shall work.
TENSIONS = np.array([0.95, 1.0, 1.05])


def antenna(divisions: tuple[int, int] = (10, 5)) -> tf.Model:
    """The paper's antenna M2 in equilibrium, a cable at every edge node."""
    layout = AntennaLayout(
        2.0, 1.0, divisions, "alternating", 2.5, 1.5, divisions[0] + 1, divisions[1] + 1, "tributary", "corners"
    )
    return build_antenna(
        layout,
        tf.MembraneSection(tf.Material(3.5e9, 1530.0, 0.34), 1e-4),
        tf.CableSection(tf.Material(133e9, 1440.0, 0.36), 3.14e-6),
        tf.BeamSection(tf.Material(3e9, 1380.0, 0.38), 5.24e-4, 4.81e-7, 2.69e-7, 7.5e-7),
        pretension_x=0.59 / divisions[1],
        pretension_y=2.0 / divisions[0],
    )


@dataclass(frozen=True)
class Turn:
    """What all profiles have in common.

    Parameters
    ----------
    angle
        [rad].
    duration
        [s].
    watched
        Time after the turn in which the vibration is judged [s].
    time_step
        [s].
    knots
        Instants of the spline, both ends included.
    """

    angle: float = 0.5
    duration: float = 3.0
    watched: float = 2.0
    time_step: float = 4e-3
    knots: int = 15

    @property
    def end_time(self) -> float:
        """End of a run [s]."""
        return self.duration + self.watched

    @property
    def largest_rate(self) -> float:
        """Peak of the bang-bang turn, the limit for the spline [rad/s]."""
        return 2.0 * self.angle / self.duration

    @property
    def times(self) -> Array:
        """Instants of the knots [s]."""
        return np.linspace(0.0, self.duration, self.knots)


def loudest_mode(state: PrestressedState) -> float:
    """Frequency [Hz] of the mode that a turn about x excites most."""
    modes = tf.solve_modes(state, n=12)
    inertia = state.system.inertia
    load = inertia.load(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]))
    share = (modes.vectors @ load) ** 2 / modes.frequencies**4
    return float(modes.frequencies[np.argmax(share)])


def optimal_rates(rom: ReducedModel, turn: Turn, iterations: int) -> Array:
    """Angular rates at the knots [rad/s] that leave least energy behind, by L-BFGS on exact gradients."""
    spline = CubicSpline(turn.times, np.eye(turn.knots))
    area = jnp.asarray(spline.integrate(0.0, turn.duration))
    between = jnp.asarray(spline(np.linspace(0.0, turn.duration, 8 * turn.knots)))
    start = tf.Slew(turn.angle, turn.duration)
    guess = np.array([start.segments()[0].motion(time).angular_velocity[0] for time in turn.times[1:-1]])
    respond = tf.Batch(rom).response(
        tf.Tabulated(turn.times, np.zeros(turn.knots)),
        method=tf.Newmark(),
        time_step=turn.time_step,
        end_time=turn.end_time,
        damping=DAMPING,
        store=("energy",),
        tolerance=1e-9,
    )

    def rates(inner: jax.Array) -> jax.Array:
        free = jnp.concatenate([jnp.zeros(1), inner, jnp.zeros(1)])
        return free * turn.angle / (area @ free)

    def cost(inner: jax.Array) -> jax.Array:
        profile = rates(inner)
        runs = respond({"maneuver.rates": profile, "tension_x": TENSIONS, "tension_y": TENSIONS})
        left = jax.vmap(lambda run: residual_energy(run, turn.duration))(runs)
        excess = jnp.maximum(jnp.abs(between @ profile) / (0.999 * turn.largest_rate) - 1.0, 0.0)
        return jnp.log(jnp.mean(left)) + 1e5 * jnp.mean(excess**2)

    found = minimize(
        jax.jit(jax.value_and_grad(cost)), guess, jac=True, method="L-BFGS-B", options={"maxiter": iterations}
    )
    return np.asarray(rates(jnp.asarray(found.x)))


def profiles(state: PrestressedState, rates: Array, turn: Turn) -> dict[str, object]:
    """The three maneuvers."""
    shaped = tf.Slew(turn.angle, turn.duration, "input-shaped", frequency=loudest_mode(state))
    return {
        "bang-bang": tf.Slew(turn.angle, turn.duration, "bang-bang"),
        "input-shaped (ZVD)": shaped,
        "optimal spline": tf.Tabulated(turn.times, rates),
    }


def judge(state: PrestressedState, maneuver: object, turn: Turn) -> tuple[float, float, Run]:
    """Mean residual energy [J], rms of w at A after the turn [m], and the run of the full model."""
    run = tf.simulate(
        state,
        maneuver,
        method=tf.Newmark(),
        time_step=turn.time_step,
        end_time=turn.end_time,
        damping=DAMPING,
        probes=PROBE,
    )
    after = run.data.where(run.data.time > turn.duration, drop=True)
    energy = float((after.kinetic_energy + after.strain_energy).mean())
    return energy, float(np.sqrt((after.w.sel(probe="A") ** 2).mean())), run


@styled
def draw(runs: dict[str, Run], turn: Turn, path: Path) -> Path:
    """Rates, deflection and what is left of it."""
    figure = new_figure(DOUBLE_COLUMN, 6.0)
    top, middle, bottom = panels = figure.subplots(3, 1, sharex=True)
    for (name, run), line in zip(runs.items(), LINES, strict=False):
        time, late = run.data["time"], run.data["time"] > turn.duration
        energy = run.data["kinetic_energy"] + run.data["strain_energy"]
        top.plot(time, run.data["angular_velocity"].sel(component="x"), line, label=name)
        middle.plot(time, 1e3 * run.data["w"].sel(probe="A"), line)
        bottom.semilogy(time[late], np.maximum(energy, 1e-14)[late], line)
    top.axhline(turn.largest_rate, color=GREY, linewidth=0.8, linestyle=":", label="limit of the rate")
    top.margins(y=0.25)  # keeps the legend's line free of curves
    top.legend(loc="upper right", ncols=4)
    for axes in panels:
        axes.axvspan(0.0, turn.duration, color="#eeeeee", zorder=0)
    top.set_ylabel("angular rate [rad/s]")
    middle.set_ylabel("$w_A$ [mm]")
    bottom.set(xlabel="time $t$ [s], shaded: the turn", ylabel="energy left [J]", xlim=(0.0, turn.end_time))
    figure.align_ylabels(panels)
    return save_figure(figure, path.with_suffix(""), ("png",))[0]


def compare(turn: Turn, iterations: int = 60) -> tuple[dict[str, tuple[float, float]], dict[str, Run]]:
    """Residual energy and rms of each profile in the full model, and the runs."""
    state = tf.solve_prestress(antenna())
    rates = optimal_rates(tf.reduce(state, tf.ModalBasis(("rx",), threshold=2e-3)), turn, iterations)
    maneuvers = profiles(state, rates, turn)
    judged = {name: judge(state, maneuver, turn) for name, maneuver in maneuvers.items()}
    return {name: found[:2] for name, found in judged.items()}, {n: found[2] for n, found in judged.items()}


def main() -> None:
    """Print the comparison and draw it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, default=Path("optimal_stop"), help="folder of the figure")
    arguments = parser.parse_args()
    turn = Turn()
    left, runs = compare(turn)
    print(f"{'profile':20s} {'peak rate [rad/s]':>18s} {'energy left [J]':>16s} {'rms of w at A [mm]':>19s}")
    for name, (energy, rms) in left.items():
        peak = float(np.abs(runs[name].data.angular_velocity).max())
        print(f"{name:20s} {peak:18.4f} {energy:16.3e} {1e3 * rms:19.5f}")
    draw(runs, turn, arguments.output / "optimal_stop.png")


if __name__ == "__main__":
    main()
