"""Files in and out: results, tables, fields for other programs, and meshes."""
