"""A full disk, for tests of what is written."""

from __future__ import annotations

import resource
from contextlib import contextmanager


@contextmanager
def files_no_longer_than(size):
    """Let writing fail as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
