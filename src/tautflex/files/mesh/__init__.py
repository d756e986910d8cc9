"""Meshes of other programs in, fields for other programs out; the numerics know nothing of either.

`read_mesh` reads Gmsh, Abaqus and Nastran files into a `MeshData`, which builds a `Model`. Files are data from
outside: whatever they hold, reading them ends in a mesh or in a tautflex error.
"""

from tautflex.files.mesh.mesh_data import MeshData
from tautflex.files.mesh.read import read_mesh
from tautflex.files.mesh.section.section_data import MeshSection

__all__ = ["MeshData", "MeshSection", "read_mesh"]
