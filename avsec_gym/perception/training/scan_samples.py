"""What samples of labelled LiDAR scans have in common, whatever frame their points are in."""

from __future__ import annotations

NEEDED = ("velodyne", "image_2", "label_2", "calib")
"""Folders in which a frame must have a file."""
FEWEST_POINTS = 5
"""Fewest points on an object that can be found."""
ABOVE_GROUND = 0.2
"""Metres: lower points at an object's place are the road's."""
