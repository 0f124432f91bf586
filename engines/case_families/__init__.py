"""Families of cases. Each module has `cases()`, which yields a case and its URDF files by name."""
