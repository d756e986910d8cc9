"""Marker of the long validation runs: ``pytest -m "not long"`` leaves them out."""

from __future__ import annotations

import pytest


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "long: a run of several seconds that covers a whole published record")
