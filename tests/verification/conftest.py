"""What verification tests share as fixtures."""

from __future__ import annotations

import pytest

import tautflex as tf


@pytest.fixture
def read(tmp_path):
    """Return a function that reads a deck from its text."""

    def from_text(suffix, text, **options):
        path = tmp_path / f"mast{suffix}"
        path.write_text(text, encoding="utf-8")
        return tf.read_mesh(path, **options)

    return from_text
