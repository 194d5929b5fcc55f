"""Names of KITTI's recordings as scenes to drive in."""

KITTI_TRACKING, KITTI_RAW = "kitti_tracking", "kitti_raw"
"""Sequences of the tracking benchmark, and raw drives with tracklets; both need a root."""
EVERY = 1.0
"""Seconds from the start of one window to the next."""
