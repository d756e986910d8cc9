"""Content of files from outside, of any kind: what is no regular file of bearable size is refused before it is read."""

from __future__ import annotations

import stat
from pathlib import Path

from tautflex.errors import InputError


def read_bytes(
    path: Path, name: str, what: str, largest: int, missing: str, error: type[InputError] = InputError
) -> bytes:
    """Read a file; directories, devices and pipes, which may never end, are not opened.

    Parameters
    ----------
    path
        The file.
    name
        How messages call it.
    what
        What it should be, ``"case file"``.
    largest
        Most bytes.
    missing
        What to try if there is no such file.
    error
        Class of the error, one line.
    """
    try:
        found = path.stat()
        if stat.S_ISREG(found.st_mode) and found.st_size <= largest:
            with path.open("rb") as file:
                return file.read(largest)  # a file of /proc has no size, and may have no end
    except FileNotFoundError:
        raise error(f"{name}: no such file; {missing}") from None
    except (OSError, ValueError) as wrong:  # ValueError: a path with a null character
        reason = wrong.strerror if isinstance(wrong, OSError) else str(wrong)
        raise error(f"{name}: cannot read the {what} ({reason}); check its path and permissions") from None
    got = f"{found.st_size / 1e6:.3g} MB; is it one?"
    if not stat.S_ISREG(found.st_mode):
        got = "a directory; name a file in it" if stat.S_ISDIR(found.st_mode) else "a device or pipe; name a file"
    raise error(f"{name}: expected a {what} of at most {largest / 1e6:g} MB, got {got}")


def read_text(
    path: Path, name: str, what: str, largest: int, missing: str, error: type[InputError] = InputError
) -> str:
    """Read a file of UTF-8 text, see `read_bytes`."""
    content = read_bytes(path, name, what, largest, missing, error)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as wrong:
        text = f"{name}: expected UTF-8 text, got byte 0x{content[wrong.start]:02x} at offset {wrong.start}"
        raise error(f"{text}; save the file as UTF-8") from None
