"""Many pictures on one, each under its title."""

from __future__ import annotations

from collections.abc import Mapping

import cv2
import numpy as np

from avsec_gym.drawing.frame_picture import contact_sheet, titled
from avsec_gym.frame import Image


def panel_sheet(panels: Mapping[str, Image], columns: int, width: int) -> Image:
    """Pictures in a grid, reduced before they get their titles, which stay readable.

    Args:
        panels: Title to picture; all of one shape.
        columns: Number of columns of the grid.
        width: Width of the whole, pixels, but for the gaps.
    """
    each = width // columns
    shown = []
    for title, panel in panels.items():
        height = round(each * panel.shape[0] / panel.shape[1])
        small = cv2.resize(panel, (each, height), interpolation=cv2.INTER_AREA)
        shown.append(titled(np.asarray(small, np.uint8), title))
    return contact_sheet(shown, columns=columns, width=each)
