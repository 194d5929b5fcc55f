"""What detectors found beside what is true: boxes in the image, footprints from above.

For users of the library (examples/notebooks/attack_a_detector.ipynb); of ours,
studies/perception draws with it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.drawing.box_edges import edges_in_image
from avsec_gym.drawing.figure_style import as_drawn
from avsec_gym.drawing.scenario_picture import INK, REAL, ROAD
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats, box_corners, rectangle_corners
from avsec_gym.kitti.labels import DONT_CARE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = ("#D55E00", "#0072B2", "#009E73", "#CC79A7")
"""Colours of detectors, in their order."""
TRUE_IN_IMAGE = "#FFFFFF"

_AHEAD, _ASIDE = 62.0, 22.0
"""Metres that the view from above shows."""


def draw_frame(
    frame: SensorFrame, truth: Boxes3D, found: Mapping[str, Boxes3D], *, title: str = ""
) -> Figure:
    """The left image once for each detector, above each other; at their right all from above.

    Args:
        frame: Frame whose image is drawn on.
        truth: The labels of the frame.
        found: Detections by the detector's name.
        title: Title above the picture.
    """
    from matplotlib.figure import Figure

    image = frame.image(2)
    height, width = image.shape[:2]
    tall = len(found) * height / width * 10.0
    above = tall * 2 * _ASIDE / _AHEAD
    figure = Figure(figsize=(10.0 + above + 0.3, tall + 0.4), dpi=110, facecolor="white")
    figure.text(0.01, 1 - 0.13 / (tall + 0.4), as_drawn(title), va="top", size=10, color=INK)
    right, top = 10.0 / (10.3 + above), tall / (tall + 0.4)
    for row, ((name, boxes), colour) in enumerate(zip(found.items(), COLOURS, strict=False)):
        part = top / len(found)
        axes = figure.add_axes((0.0, top - (row + 1) * part, right, part))
        axes.imshow(image)
        projection = frame.calibration.projection(2)
        _draw_boxes(axes, truth[truth.category != DONT_CARE], projection, TRUE_IN_IMAGE, 0.8)
        _draw_boxes(axes, boxes, projection, colour, 1.6)
        axes.set_xlim(0, width)
        axes.set_ylim(height, 0)
        axes.axis("off")
        axes.text(8, 10, as_drawn(name), color="white", size=9, weight="bold", va="top",
                  bbox={"facecolor": colour, "edgecolor": "none", "pad": 2.5})  # fmt: skip
    draw_from_above(
        figure.add_axes((right + 0.1 / (10.3 + above), 0.0, above / (10.3 + above), top)),
        truth,
        found,
    )
    return figure


def draw_frames_from_above(frames: Mapping[str, tuple[Boxes3D, Mapping[str, Boxes3D]]]) -> Figure:
    """Frames beside each other, without photographs.

    Args:
        frames: Labels, and detections by the detector's name, by what to call the frame.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(3.1 * len(frames), 4.9), dpi=110, facecolor="white")
    figure.subplots_adjust(0.01, 0.07, 0.99, 0.94, wspace=0.04)
    panels = figure.subplots(1, len(frames), squeeze=False)[0]
    for axes, (name, (truth, found)) in zip(panels, frames.items(), strict=True):
        draw_from_above(axes, truth, found)
        axes.set_title(as_drawn(name), loc="left", size=10, color=INK)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=5, frameon=False, fontsize=9)
    return figure


def draw_from_above(axes: Axes, truth: Boxes3D, found: Mapping[str, Boxes3D]) -> None:
    """True cars filled, other true objects hatched, detections as outlines with their scores.

    Args:
        axes: Axes to draw into: forward is up.
        truth: The labels of the frame.
        found: Detections by the detector's name, in the order of `COLOURS`.
    """
    from matplotlib.collections import PolyCollection

    # Distances, and the camera's field of view.
    # The ground: lines of distance, and the camera's field of view.
    axes.set_facecolor(ROAD)
    for distance in range(10, int(_AHEAD), 10):
        axes.axhline(distance, color="white", lw=0.8, zorder=0)
        axes.text(-_ASIDE + 0.5, distance, f"{distance} m", color=REAL, size=7, va="bottom")
    field = np.array([(0, 0), (-_AHEAD, _AHEAD), (_AHEAD, _AHEAD)])
    axes.fill(*(field * (0.85, 1.0)).T, color="white", alpha=0.45, zorder=0, lw=0)
    # True objects below, detections above them.
    true = truth[truth.category != DONT_CARE]
    is_car = true.category == "Car"
    axes.add_collection(
        PolyCollection(
            _footprints(true[is_car]), facecolor=REAL, edgecolor=INK, lw=0.6, label="true car"
        )
    )
    axes.add_collection(
        PolyCollection(
            _footprints(true[~is_car]),
            facecolor="none",
            edgecolor=REAL,
            hatch="/////",
            lw=0.6,
            label="other true object",
        )
    )
    for (name, boxes), colour in zip(found.items(), COLOURS, strict=False):
        outlines = _footprints(boxes)
        axes.add_collection(
            PolyCollection(
                outlines, facecolor="none", edgecolor=colour, lw=1.5, label=as_drawn(name)
            )
        )
        for outline, score in zip(outlines, boxes.score, strict=True):
            nose = outline[[0, 3]].mean(axis=0), outline.mean(axis=0)
            axes.plot(*zip(*nose, strict=True), color=colour, lw=1.2)
            right_most = outline[outline[:, 0].argmax()]
            axes.annotate(f"{score:.2f}", right_most, (2, 0), textcoords="offset points",
                          color=colour, size=6, va="center", annotation_clip=True)  # fmt: skip
    axes.set_xlim(-_ASIDE, _ASIDE)
    axes.set_ylim(0, _AHEAD)
    axes.set_aspect("equal")
    axes.set_xticks([])
    axes.set_yticks([])
    axes.spines[:].set_visible(False)


def _footprints(boxes: Boxes3D) -> list[Floats]:
    """Right and forward of the corners, shape (4, 2) each, metres."""
    corners = rectangle_corners(boxes.poses, boxes.length, boxes.width)
    return list(np.stack([-corners[..., 1], corners[..., 0]], axis=-1))


def _draw_boxes(
    axes: Axes, boxes: Boxes3D, projection: Floats, colour: str, thickness: float
) -> None:
    """Edges as far as they lie before the camera."""
    every = box_corners(boxes.location, boxes.dimensions, boxes.rotation_y)
    for corners in every:
        for pixels in edges_in_image(corners, projection):
            axes.plot(*pixels.T, color=colour, lw=thickness, solid_capstyle="round")
