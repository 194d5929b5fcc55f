"""Recorded traffic of KITTI: tracked objects, the car's own motion, and scenes of both."""
