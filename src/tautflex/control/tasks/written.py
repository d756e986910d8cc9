"""Files that are whole or not there."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tautflex.errors import InputError


@contextmanager
def written(target: Path) -> Iterator[Path]:
    """Place to write to, which takes the target's name at the end; InputError if that cannot be written."""
    temporary = target.with_name(f".{target.name}.{uuid.uuid4().hex}.part")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        temporary.replace(target)
    except OSError as error:
        text = f"path: expected a file that can be written, got {str(target)!r} ({error})"
        raise InputError(f"{text}; choose another folder") from None
    finally:
        temporary.unlink(missing_ok=True)
