"""Cameras and LiDAR: rays by embree, shading by numba.

The kernels do without numba's `fastmath`: it would let the compiler round differently wherever it
happens to inline, and pixels would depend on who compiled first.
"""
