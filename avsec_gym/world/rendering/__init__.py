"""Cameras and LiDAR: rays by embree, shading by numba."""
