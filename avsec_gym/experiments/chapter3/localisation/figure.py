"""One attack as a strip of pictures: clean, attacked, found beside true, repaired."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from avsec_gym.attacks.optical_attack import TamperedFrame
from avsec_gym.drawing.figure_style import FIGURE_STYLE
from avsec_gym.frame import Points, SensorFrame
from avsec_gym.geometry import project, transform_points
from avsec_gym.validation.repair.repair import Repair

_BOTH, _ONLY_FOUND, _ONLY_TRUE = (46, 160, 67), (31, 119, 180), (215, 38, 61)
_TITLES = ("clean", "attacked", "green: found, blue: found but sound, red: missed", "repaired")
_NEAR, _FAR = 4.0, 50.0


def draw_repair(frame: SensorFrame, tampered: TamperedFrame, repaired: Repair) -> Figure:
    """Four panels of an attacked camera's image, or of the scan in camera 2's.

    Args:
        frame: The clean frame.
        tampered: The same frame, one sensor attacked.
        repaired: What became of it.
    """
    import matplotlib as mpl

    with mpl.rc_context(FIGURE_STYLE):
        figure = Figure(figsize=(7.0, 9.2), dpi=90, facecolor="white", layout="constrained")
        panels = figure.subplots(4)
        if tampered.pixels:
            _draw_images(panels, frame, tampered, repaired)
        else:
            _draw_scans(panels, frame, tampered, repaired)
        for axes, title in zip(panels, _TITLES, strict=True):
            axes.set(xticks=[], yticks=[])
            axes.set_title(title, loc="left")
    return figure


def _draw_images(
    panels: NDArray[Any], frame: SensorFrame, tampered: TamperedFrame, repaired: Repair
) -> None:
    ((camera, true),) = tampered.pixels.items()
    found = repaired.pixels[camera]
    attacked = tampered.frame.image(camera)
    marked = attacked.astype(float)
    for area, colour in (
        (found & true, _BOTH),
        (found & ~true, _ONLY_FOUND),
        (true & ~found, _ONLY_TRUE),
    ):
        marked[area] = 0.45 * marked[area] + 0.55 * np.array(colour)
    images = (frame.image(camera), attacked, marked.astype(np.uint8), repaired.frame.image(camera))
    for axes, image in zip(panels, images, strict=True):
        axes.imshow(image)


def _draw_scans(
    panels: NDArray[Any], frame: SensorFrame, tampered: TamperedFrame, repaired: Repair
) -> None:
    assert tampered.points is not None, "a bogus return is points"
    assert repaired.scan is not None, "the LiDAR was named"
    points, true, found = tampered.frame.points, tampered.points, repaired.scan.points
    for axes in panels:
        axes.imshow(frame.image(2), alpha=0.35)
    for axes, scan in (
        (panels[0], frame.points),
        (panels[1], points),
        (panels[3], repaired.frame.points),
    ):
        _dots(axes, frame, scan, None)
    for chosen, colour in (
        (~found & ~true, (190, 190, 190)),
        (found & true, _BOTH),
        (found & ~true, _ONLY_FOUND),
        (true & ~found, _ONLY_TRUE),
    ):
        _dots(panels[2], frame, points[chosen], colour)


def _dots(axes: Axes, frame: SensorFrame, points: Points, colour: tuple[int, ...] | None) -> None:
    """Points in camera 2's image; without a colour, coloured by how far away they are."""
    in_camera = transform_points(frame.calibration.velodyne_to_camera, points[:, :3])
    pixels, depth = project(frame.calibration.projection(2), in_camera)
    height, width = frame.image(2).shape[:2]
    inside = (depth > 0) & (pixels >= 0).all(axis=1) & (pixels < (width, height)).all(axis=1)
    u, v = pixels[inside].T
    if colour is None:
        far = np.log(depth[inside])
        limits: dict[str, Any] = {"vmin": np.log(_NEAR), "vmax": np.log(_FAR), "cmap": "turbo_r"}
        axes.scatter(u, v, s=0.5, c=far, linewidths=0, **limits)
    else:
        axes.scatter(u, v, s=0.5, color=np.array(colour) / 255, linewidths=0)
    axes.set(xlim=(0, width - 1), ylim=(height - 1, 0))
