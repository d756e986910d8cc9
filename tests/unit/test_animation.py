"""Films of runs: what they show, and what cannot be filmed."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

import tautflex as tf
from tautflex.analysis.turning import recorded_attitude
from tautflex.cli import main
from tautflex.motion.rotations import matrix
from verification.dynamic_cases import small_antenna


@pytest.fixture(scope="module")
def run():
    state = tf.solve_prestress(small_antenna())
    stop = tf.Stop(2.0, 0.1)
    return tf.simulate(state, stop, time_step=5e-3, end_time=0.2, probes={"A": (0.2, 0.1)}, fields="all")


def frames_of(path):
    with Image.open(path) as film:
        found = []
        for number in range(film.n_frames):
            film.seek(number)
            found.append(np.asarray(film.convert("RGB")).copy())
    return found


def test_film_turns_and_rings(run, tmp_path):
    path = tf.animate(run, tmp_path / "stop.gif", frames=6, dots=50)
    frames = frames_of(path)
    assert len(frames) == 6
    assert frames[0].shape == (250, 350, 3)
    assert all(frame.std() > 10.0 for frame in frames)
    assert all(np.any(a != b) for a, b in pairwise(frames))
    still = tf.animate(run, tmp_path / "still.gif", frames=2, dots=50, turning=False)
    assert len(frames_of(still)) == 2


def test_attitude_of_a_film_is_that_of_the_maneuver(run):
    """2 rad/s down to rest in 0.1 s: 0.1 rad."""
    turns = [matrix(row) for row in recorded_attitude(run.data, np.array([0.0, 0.2]))]
    assert turns[0] == pytest.approx(np.eye(3))
    assert np.arctan2(turns[1][2, 1], turns[1][1, 1]) == pytest.approx(0.1, abs=1e-9)


def test_command_writes_a_page(run, tmp_path, capsys):
    tf.save(run, tmp_path / "run.nc")
    film = tmp_path / "stop.html"
    assert main(["animate", str(tmp_path / "run.nc"), "-o", str(film), "--frames", "2"]) == 0
    assert main(["animate", str(tmp_path), "-o", str(film), "--frames", "2", "--force"]) == 0  # the run's folder
    text = film.read_text()
    assert text.count("data:image/png;base64") == 2
    assert main(["animate", str(tmp_path / "run.nc"), "-o", str(film)]) == 2
    assert "--force" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"path": "film.avi"}, "path: expected one of"),
        ({"frames": 1}, "frames"),
        ({"magnification": -1.0}, "magnification"),
        ({"rate": 0.0}, "rate"),
    ],
)
def test_what_cannot_be_filmed_is_said(run, tmp_path, options, words):
    path = tmp_path / options.pop("path", "film.gif")
    with pytest.raises(tf.InputError, match=words):
        tf.animate(run, path, **options)
    assert not list(tmp_path.iterdir())
