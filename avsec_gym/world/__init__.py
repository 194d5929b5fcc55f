"""The procedural look-alike of KITTI: scenes, traffic, cameras, LiDAR from nothing but a seed."""
