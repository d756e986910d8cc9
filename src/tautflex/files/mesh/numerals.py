"""Strict reading of numbers in foreign text: what is no number is an error, never a guess."""

from __future__ import annotations

import re

from tautflex.errors import MeshError
from tautflex.files.mesh.raw import LARGEST_NUMBER, shorten

# "1.5-3" is Nastran's short form of 1.5e-3, "1.5d-3" Fortran's.
_REAL = re.compile(r"([+-]?(?:\d{1,40}\.?\d{0,40}|\.\d{1,40}))(?:[eEdD]?([+-]\d{1,4})|[eEdD](\d{1,4}))?", re.ASCII)


def integer(text: str, where: str) -> int:
    """Read an integer of at most 62 bits, or raise MeshError."""
    bare = text.strip()
    digits = bare[1:] if bare[:1] in ("+", "-") else bare
    if not (digits.isascii() and digits.isdigit() and len(digits) <= 19):
        raise MeshError(f"{where}: expected an integer, got {shorten(text)}; correct the line")
    value = int(bare)
    if abs(value) > LARGEST_NUMBER:
        raise MeshError(f"{where}: expected an integer up to 2^62, got {value}; renumber the mesh")
    return value


def natural(text: str, where: str) -> int:
    """Read an integer >= 1, or raise MeshError."""
    value = integer(text, where)
    if value < 1:
        raise MeshError(f"{where}: expected a number >= 1, got {value}; correct the line")
    return value


def real(text: str, where: str) -> float:
    """Read a number, blank being 0, in the spellings of Abaqus and Nastran; infinities are left to the caller.

    Raises
    ------
    MeshError
        If the text is no number; ``nan`` and ``inf`` are none.
    """
    bare = text.strip()
    if not bare:
        return 0.0
    found = _REAL.fullmatch(bare)
    if found is None:
        raise MeshError(f"{where}: expected a number, got {shorten(text)}; correct the line")
    return float(f"{found[1]}e{found[2] or found[3] or 0}")
