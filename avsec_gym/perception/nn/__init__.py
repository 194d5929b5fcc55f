"""Layers that several networks share, in plain torch."""
