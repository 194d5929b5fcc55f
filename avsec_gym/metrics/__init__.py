"""Verdicts on planned trajectories and the rates that follow from them."""
