"""How close the procedural world is to KITTI: measurements of both, and their page."""
