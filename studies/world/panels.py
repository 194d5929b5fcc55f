"""Many pictures on one, each under its title."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np

from avsec_gym.drawing.frame_picture import contact_sheet
from avsec_gym.frame import Image

STRIP = 30
"""Height of a title, pixels: large enough for pages that show the whole in half its size."""


def panel_sheet(panels: Mapping[str, Image], columns: int, width: int) -> Image:
    """Pictures in a grid, reduced before they get their titles.

    Args:
        panels: Title to picture; all of one shape.
        columns: Number of columns of the grid.
        width: Width of the whole, pixels, but for the gaps.
    """
    each = width // columns
    shown = []
    for title, panel in panels.items():
        height = round(each * panel.shape[0] / panel.shape[1])
        small = np.asarray(
            cv2.resize(panel, (each, height), interpolation=cv2.INTER_AREA), np.uint8
        )
        whole = np.pad(small, ((STRIP, 0), (0, 0), (0, 0)), constant_values=255)
        place = (4, STRIP - 9)
        cv2.putText(whole, title, place, cv2.FONT_HERSHEY_SIMPLEX, 0.75, (0, 0, 0), 1, cv2.LINE_AA)
        shown.append(whole)
    return contact_sheet(shown, columns=columns, width=each)
