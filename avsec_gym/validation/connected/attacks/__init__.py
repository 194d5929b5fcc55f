"""Attacks on the LiDAR of one of several connected vehicles, at one instant."""
