"""Public names: all there, loaded when used, the same for people and for type checkers."""

from __future__ import annotations

import subprocess
import sys

import pytest

import tautflex as tf
from tautflex import analysis, plot

SCRIPT = """
import sys
import tautflex
import tautflex.plot, tautflex.analysis
assert not {"numpy", "matplotlib", "pywt"} & set(sys.modules)
tautflex.mac
assert "numpy" in sys.modules
assert not {"matplotlib", "pywt"} & set(sys.modules)
"""


def test_nothing_is_loaded_before_it_is_used():
    subprocess.run([sys.executable, "-c", SCRIPT], check=True)


@pytest.mark.parametrize("package", [tf, analysis, plot], ids=lambda package: package.__name__)
def test_every_name_is_what_it_says(package):
    assert package.__all__ == dir(package)
    for name in package.__all__:
        value = getattr(package, name)
        assert getattr(value, "__name__", name).removeprefix("tautflex.") == name


def test_a_name_that_is_none_raises_what_python_raises_and_asks_for_the_nearest():
    with pytest.raises(
        AttributeError, match=r"'tautflex' has no attribute 'simulat'; did you mean 'simulate'\?$"
    ) as it:
        _ = tf.simulat
    assert it.value.name == "simulat"
    for name, package in (("animte", tf), ("spectrm", analysis), ("plot_surfac", plot)):
        with pytest.raises(AttributeError, match=r"; did you mean '\w+'\?$"):
            getattr(package, name)
    for name in ("qqqqqq", "_simulate", "__wrapped__"):  # nothing near, or nothing public
        with pytest.raises(AttributeError, match=f"attribute '?{name}'?$"):
            getattr(tf, name)
    said = subprocess.run([sys.executable, "-c", "import tautflex as tf; tf.simulat"], capture_output=True, text=True)
    assert said.stderr.count("id you mean") == 1
    with pytest.raises(ImportError, match="simulat"):
        from tautflex import simulat  # noqa: F401


def test_completion_lists_the_public_names_and_no_others():
    completer = pytest.importorskip("IPython.core.completer")
    offered = {name.removeprefix("tf.") for name in completer.Completer(namespace={"tf": tf}).attr_matches("tf.")}
    hidden = {name for name in offered if name.startswith("__")}  # what IPython offers after tf.__ alone
    assert offered - hidden == set(tf.__all__) - {"__version__"}


def test_functions_hide_modules_of_their_name():
    import tautflex.analysis.pod
    import tautflex.solvers.modal.campbell

    assert callable(tautflex.analysis.pod)
    assert callable(tautflex.pod)
    assert callable(tautflex.campbell)
