"""Runs that share a prestressed state do not see each other: a run owns everything it writes to."""

from __future__ import annotations

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import tautflex as tf

PULLS = (0.2, -0.1)
COMPARED = ("w", "strain_energy", "min_principal_resultant", "max_principal_resultant", "wrinkled_fraction")


def state_of_antenna():
    """Small antenna of the paper's kind, with a case file's defaults."""
    from tautflex.case.reading import parse_case, template

    case = parse_case(template("m2-nearest-node"), ["mesh.divisions=[10, 5]"])
    return tf.solve_prestress(tf.build_model(case))


def pulled_run(state, pull: float) -> dict[str, np.ndarray]:
    """Run whose cable tension changes in time: it writes to initial stresses and to stresses."""
    run = tf.simulate(
        state,
        tf.Stop(rate=0.3, duration=0.1),
        time_step=1e-3,
        end_time=0.3,
        damping=tf.Rayleigh(0.001, 0.001),
        inputs=[tf.CableTension(lambda time: pull * np.sin(20.0 * time))],
        probes={"A": (0.3, 0.2)},
    )
    return {name: run.data[name].values for name in COMPARED}


@pytest.fixture(scope="module")
def single():
    state = state_of_antenna()
    return state, [pulled_run(state, pull) for pull in PULLS]


def assert_same(found, expected):
    for got, wanted in zip(found, expected, strict=True):
        for name in COMPARED:
            np.testing.assert_array_equal(got[name], wanted[name], err_msg=name)


def test_two_threads_on_one_state_are_the_single_runs(single):
    state, expected = single
    assert np.abs(expected[0]["w"] - expected[1]["w"]).max() > 1e-6  # the pulls matter
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    try:
        with ThreadPoolExecutor(2) as pool:
            found = list(pool.map(lambda pull: pulled_run(state, pull), PULLS))
    finally:
        sys.setswitchinterval(before)
    assert_same(found, expected)


@pytest.mark.slow
def test_two_processes_are_the_single_runs(single, tmp_path):
    files = [tmp_path / f"{number}.npz" for number in range(len(PULLS))]
    commands = [[sys.executable, __file__, str(pull), str(file)] for pull, file in zip(PULLS, files, strict=True)]
    running = [subprocess.Popen(command) for command in commands]
    assert [process.wait() for process in running] == [0, 0]
    assert_same([np.load(file) for file in files], single[1])


def test_a_state_is_frozen(single):
    with pytest.raises(AttributeError):
        single[0].system.initial_stress = ()


if __name__ == "__main__":
    np.savez(sys.argv[2], **pulled_run(state_of_antenna(), float(sys.argv[1])))
