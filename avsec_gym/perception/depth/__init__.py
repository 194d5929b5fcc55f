"""Depth of every pixel, by one interface."""

from avsec_gym.perception.depth.depth import DepthEstimator, DisparityMap, make_depth

__all__ = ["DepthEstimator", "DisparityMap", "make_depth"]
