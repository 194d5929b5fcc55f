"""Stereo 3D detectors: b = O(I_l, I_r)."""
