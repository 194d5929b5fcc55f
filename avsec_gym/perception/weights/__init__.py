"""Weights: those that come with the package, and published checkpoints."""
