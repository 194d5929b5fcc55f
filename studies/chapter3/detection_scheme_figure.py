"""A picture of how three sensors detect an attack: maps, their comparison, E beside its threshold.

Run ``python -m studies.chapter3.detection_scheme_figure --out docs/images``.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from avsec_gym.attacks.lidar_spoofing import LidarSpoofing
from avsec_gym.drawing.figure_style import FIGURE_STYLE
from avsec_gym.drawing.scenario_picture import save_picture
from avsec_gym.drawing.validation_picture import compared_picture
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats
from avsec_gym.perception.depth.depth import DisparityMap
from avsec_gym.validation.detection import LIDAR_AND_TWO_CAMERAS
from avsec_gym.validation.evidence.comparison import comparison_map
from avsec_gym.validation.evidence.disparity_error import DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.fitting import CleanFrames, fit_threshold_table
from avsec_gym.validation.recordings import RecordedFrame
from avsec_gym.validation.thresholds import Threshold
from avsec_gym.validation.validator import SHARES
from avsec_gym.world.export import world_frames
from studies.answer import exit_code

_NAME = "detection_scheme.png"
_SUITE, _SHOWN = "mixed", "000030"
_CLEAN = 20
_RATE = 0.01
_TRIPLE = LIDAR_AND_TWO_CAMERAS.triples[0]
_NEARER_THAN = 60.0
"""Pixels of disparity that have the brightest colour."""


def draw_detection_scheme(frame: SensorFrame, threshold: Threshold, seed: int = 0) -> Figure:
    """Figures 3.3 and 3.4 with data: left clean, right with a bogus return.

    Args:
        frame: A frame with the images of cameras 2 and 3 and a scan.
        threshold: The threshold of all shares.
        seed: Seed of the attack.

    Raises:
        DataError: It lacks one of them.
    """
    import matplotlib as mpl

    spoofed = LidarSpoofing(reference=LIDAR_AND_TWO_CAMERAS.reference).attack(frame, seed).frame
    with mpl.rc_context(FIGURE_STYLE):
        figure = Figure(figsize=(9.2, 6.6), dpi=110, facecolor="white", layout="constrained")
        panels = figure.subplots(4, 2)
        for column, (given, source) in enumerate((("clean", frame), ("attacked", spoofed))):
            _draw_column(panels[:, column], source, given, threshold)
    return figure


def _draw_column(
    panels: NDArray[np.object_], frame: SensorFrame, given: str, threshold: Threshold
) -> None:
    maps = DisparityMaps(frame, LIDAR_AND_TWO_CAMERAS, PairDepth("sgbm"))
    i, j, k = _TRIPLE
    image = frame.image(LIDAR_AND_TWO_CAMERAS.reference)
    compared = comparison_map(maps[i, k], maps[j, k])
    error = DisparityErrors(maps)[_TRIPLE]
    shares = ", ".join(
        f"{name} {100 * value:.1f} % {'>' if value > limit else '≤'} {100 * limit:.1f} %"
        for measure, name in SHARES.items()
        if (value := getattr(error, measure)) > (limit := getattr(threshold, measure))
        or measure == "error"
    )
    decision = "alarm" if threshold.exceeded(error) else "no alarm"
    for axes, picture, title in zip(
        panels,
        (
            image,
            _coloured(maps[i, k].rescaled(maps[j, k].focal_times_baseline), image, sparse=True),
            _coloured(maps[j, k], image),
            compared_picture(image, compared, True),
        ),
        (
            f"{given}: the reference, camera {LIDAR_AND_TWO_CAMERAS.reference}",
            "its disparity map from the LiDAR",
            "its disparity map from camera 3",
            f"red contradicts: {decision}\n{shares}",
        ),
        strict=True,
    ):
        _show(axes, picture, title)


def _coloured(found: DisparityMap, image: NDArray[np.uint8], sparse: bool = False) -> Floats:
    """Disparities on the image in grey; points of a scan are drawn larger."""
    from matplotlib import colormaps

    values = np.nan_to_num(found.values, nan=-1.0)
    if sparse:
        values = np.asarray(cv2.dilate(values, np.ones((3, 3), np.uint8)))
    grey = np.repeat(image.mean(axis=2, keepdims=True), 3, axis=2) / 255 * 0.4 + 0.55
    colours = colormaps["turbo"](np.clip(values / _NEARER_THAN, 0, 1))[..., :3]
    return np.where((values >= 0)[..., None], colours, grey)


def _show(axes: Axes, picture: Any, title: str) -> None:
    axes.imshow(picture)
    axes.set(xticks=[], yticks=[])
    axes.set_title(title, loc="left")


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("."), help="folder")
    parser.add_argument("--frame", default=_SHOWN, help=f"of the suite {_SUITE}")
    options = parser.parse_args(arguments)

    def work() -> None:
        data = world_frames(_SUITE)
        clean = [id for id in data.ids() if id != options.frame][:_CLEAN]
        if options.frame not in data.ids():
            raise ConfigurationError(f"the suite {_SUITE} has no frame {options.frame!r}")
        depth = PairDepth("sgbm")
        frames = [RecordedFrame(id, partial(data.frame, id)) for id in clean]
        named = {"suite": _SUITE}
        table = fit_threshold_table(CleanFrames(frames, LIDAR_AND_TWO_CAMERAS, depth, named))
        threshold = table.thresholds(_RATE)[_TRIPLE]
        figure = draw_detection_scheme(data.frame(options.frame), threshold)
        save_picture(figure, options.out / _NAME, overwrite=True)

    return exit_code(work)


if __name__ == "__main__":
    sys.exit(main())
