"""Drives in closed loop under several settings, side by side: one row and one film each."""
