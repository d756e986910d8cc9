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


def test_a_name_that_is_none_raises_what_python_raises():
    with pytest.raises(AttributeError, match="simulat") as caught:
        _ = tf.simulat
    assert (caught.value.name, caught.value.obj) == ("simulat", tf)  # Python suggests `simulate` from these
    with pytest.raises(ImportError, match="simulat"):
        from tautflex import simulat  # noqa: F401


def test_functions_hide_modules_of_their_name():
    import tautflex.analysis.pod
    import tautflex.solvers.modal.campbell

    assert callable(tautflex.analysis.pod)
    assert callable(tautflex.pod)
    assert callable(tautflex.campbell)
