"""Surfaces of what vehicles scanned in a region: meshes, grids of heights, their distance."""
