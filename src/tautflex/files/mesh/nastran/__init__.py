"""Nastran bulk data: grid points, films, rods, bars and beams, coordinate systems, single-point constraints.

Own, because pyNastran (1.4.1) asks for numpy < 2. What becomes of each card is in `cards.WORDS`, and in docs/meshes.md.
"""

from tautflex.files.mesh.nastran.cards import WORDS
from tautflex.files.mesh.nastran.deck import read_nastran

__all__ = ["WORDS", "read_nastran"]
