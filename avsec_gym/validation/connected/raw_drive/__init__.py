"""Scans of one vehicle at intervals that stand for vehicles at one instant, as in the thesis."""
