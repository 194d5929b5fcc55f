"""Depth of every pixel, by one interface."""
