"""A picture of the optical attacks: faculae in an image, a bogus return in image and scan.

Run ``python -m studies.chapter3.optical_attacks_figure --out docs/images``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.drawing.figure_style import FIGURE_STYLE
from avsec_gym.drawing.scenario_picture import save_picture
from avsec_gym.frame import Points, SensorFrame
from avsec_gym.geometry import Floats, project, transform_points
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.world.export import world_frames
from studies.answer import exit_code

_NAME = "optical_attacks.png"
_BOGUS, _LOST = "#D7263D", "#F2A65A"


def draw_optical_attacks(frame: SensorFrame) -> Figure:
    """Two faculae, and a bogus return seen by the camera and from above.

    Args:
        frame: A frame with the image of camera 2 and a scan.

    Raises:
        DataError: It lacks one of them.
    """
    import matplotlib as mpl

    with mpl.rc_context(FIGURE_STYLE):
        figure = Figure(figsize=(8.6, 5.4), dpi=110, facecolor="white", layout="constrained")
        panels = figure.subplot_mosaic([["a", "d"], ["b", "d"], ["c", "d"]], width_ratios=[1.7, 1])
        width, height = frame.image(2).shape[1::-1]
        centre = (0.62 * width, 0.55 * height)
        green = Facula(radius=187.0, centre=centre, colour=(0.1, 1.0, 0.2), saturation=0.5)
        faculae = {
            "a": ("Gaussian, as in the thesis: radius 187 px", Facula(2, 187.0, centre)),
            "b": ("green laser, saturation 0.5", green),
        }
        for panel, (title, facula) in faculae.items():
            panels[panel].imshow(facula.attack(frame).frame.image(2))
            panels[panel].set_title(title, loc="left")
        tampered = LidarSpoofing(bearing=-0.1, distance=8.0, rays_lost=True).attack(frame)
        assert tampered.points is not None
        assert tampered.lost is not None
        points, bogus = tampered.frame.points, tampered.points
        panels["c"].imshow(frame.image(2))
        _dots(panels["c"], _pixels(frame, points[~bogus]), "white", 0.15)
        _dots(panels["c"], _pixels(frame, points[bogus]), _BOGUS, 1.0)
        panels["c"].set(xlim=(0, width - 1), ylim=(height - 1, 0))
        panels["c"].set_title("bogus return of 2.5 x 1.5 m, 8 m away", loc="left")
        above = panels["d"]
        for part, colour, label in (
            (points[~bogus], "#666666", "the scan"),
            (frame.points[tampered.lost], _LOST, "lost behind it, if rays_lost"),
            (points[bogus], _BOGUS, "bogus points"),
        ):
            _dots(above, np.c_[-part[:, 1], part[:, 0]], colour, 0.4, label)
        above.set(xlim=(-14, 14), ylim=(-2, 40), aspect="equal")
        above.legend(loc="upper right", markerscale=10, fontsize=7)
        for axes in panels.values():
            axes.set(xticks=[], yticks=[])
    return figure


def _pixels(frame: SensorFrame, points: Points) -> Floats:
    in_camera = transform_points(frame.calibration.velodyne_to_camera, points[:, :3])
    pixels, depth = project(frame.calibration.projection(2), in_camera)
    return pixels[depth > 0]


def _dots(axes: Axes, places: Floats, colour: str, size: float, label: str | None = None) -> None:
    axes.scatter(places[:, 0], places[:, 1], s=size, color=colour, linewidths=0, label=label)


def main(arguments: Sequence[str] | None = None) -> int:
    """Write ``optical_attacks.png``; returns the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--kitti", type=Path, help="object root; default: the procedural world")
    parser.add_argument("--frame", default="000012", help="such as 000012")
    parser.add_argument("--out", type=Path, default=Path("docs/images"), help="folder")
    options = parser.parse_args(arguments)

    def work() -> None:
        data = world_frames("mixed") if options.kitti is None else KittiObject(options.kitti)
        figure = draw_optical_attacks(data.frame(options.frame))
        save_picture(figure, options.out / _NAME, overwrite=True)

    return exit_code(work)


if __name__ == "__main__":
    sys.exit(main())
