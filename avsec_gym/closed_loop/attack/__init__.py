"""Attacks on a car that drives on: one kind, one file; they last from frame to frame."""
