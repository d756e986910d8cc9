"""Gmsh meshes, read by Gmsh in a process of its own."""

from tautflex.files.mesh.gmsh.reader import read_gmsh

__all__ = ["read_gmsh"]
