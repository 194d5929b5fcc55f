"""The procedural look-alike of KITTI: scenes, traffic, cameras and LiDAR from nothing but a seed."""
