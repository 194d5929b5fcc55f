"""Figures of the thesis' chapter 4, to stand beside ours; rates as fractions."""

from __future__ import annotations

DETECTION = {0.1: 0.70, 0.3: 0.90}
"""Detection rate by r (figure 4b): "very close to 70 %", and "over 90 %"."""
DISTANCE_BOUND = 0.8
"""Metres: most attack-free distances are smaller, and most attacked ones larger (figure 4a)."""
