"""Abaqus and CalculiX input files: parts, instances, assembly; films, trusses, beams; sets and boundary conditions.

Own, because meshio (5.3.5) reads no boundary conditions, and its own tests fail since NumPy 2.2. What becomes of each
keyword is in `keywords.WORDS`, and in docs/meshes.md.
"""

from tautflex.files.mesh.abaqus.input_file import read_abaqus
from tautflex.files.mesh.abaqus.keywords import WORDS

__all__ = ["WORDS", "read_abaqus"]
