"""Materials, sections, meshes, the antenna builder and the frozen model."""
