"""Strict reading of numbers in foreign text: what is no number is an error, never a guess."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from tautflex.errors import MeshError
from tautflex.files.mesh.raw import shorten
from tautflex.numeric import Array

# "1.5-3" is Nastran's short form of 1.5e-3, "1.5d-3" Fortran's.
NUMBER = re.compile(r"([+-]?(?:\d{1,40}\.?\d{0,40}|\.\d{1,40}))(?:[eEdD]?([+-]\d{1,4})|[eEdD](\d{1,4}))?", re.ASCII)
_INTEGER = re.compile(r"\s*[+-]?\d{1,19}\s*", re.ASCII)
_LARGEST = 2**62
_LARGEST_LENGTH = 1e9


def natural(text: str, where: str) -> int:
    """Read an integer from 1 to 2^62, or raise MeshError."""
    if _INTEGER.fullmatch(text) is None:
        raise MeshError(f"{where}: expected an integer, got {shorten(text)}; correct the line")
    value = int(text)
    if not 1 <= value <= _LARGEST:
        expected = "a number >= 1" if value < 1 else "an integer up to 2^62"
        raise MeshError(f"{where}: expected {expected}, got {value}; correct the line or renumber the mesh")
    return value


def vector(texts: Sequence[str], where: str, largest: float = _LARGEST_LENGTH) -> Array:
    """Read numbers up to ``largest``, blank being 0; of lengths below 1e9 products and rotations stay finite."""
    values = [real(text, where) for text in texts]
    large = [value for value in values if not abs(value) <= largest]
    if large:
        raise MeshError(f"{where}: expected finite numbers below {largest:g}, got {large[0]:g}; correct the line")
    return np.array(values)


def finite(text: str, where: str, largest: float = 1e300) -> float:
    """Read one number up to ``largest``, blank being 0."""
    return float(vector([text], where, largest)[0])


def real(text: str, where: str) -> float:
    """Read a number, blank being 0, in the spellings of Abaqus and Nastran; infinities are left to the caller.

    What is no number, ``nan`` and ``inf`` among it, is a MeshError.
    """
    bare = text.strip()
    if not bare:
        return 0.0
    found = NUMBER.fullmatch(bare)
    if found is None:
        raise MeshError(f"{where}: expected a number, got {shorten(text)}; correct the line")
    return float(f"{found[1]}e{found[2] or found[3] or 0}")
