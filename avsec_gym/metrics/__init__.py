"""The collision check of planned trajectories, rates with intervals, average precision."""
