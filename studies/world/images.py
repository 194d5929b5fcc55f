"""Brightness, contrast, sharpness, colour and noise of rendered images against real ones.

Run ``python -m studies.world.images --frames 100 --kitti ROOT``.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from avsec_gym.frame import Image
from avsec_gym.kitti.dataset import KittiObject
from avsec_gym.world.capture import Capture, Float32s
from avsec_gym.world.posed_scenes import PosedScene
from studies.world.command import command, measure_one

QUANTITIES = {
    "mean": "mean brightness",
    "deviation": "standard deviation",
    "p5": "5th percentile",
    "p50": "median",
    "p95": "95th percentile",
    "saturated": "brighter than 250, %",
    "dark": "darker than 25, %",
    "detail_half": "detail of 0.5 px",
    "detail_1": "detail of 1 px",
    "detail_2": "detail of 2 px",
    "detail_4": "detail of 4 px",
    "road_mean": "road: mean brightness",
    "road_detail_half": "road: detail of 0.5 px",
    "road_detail_1": "road: detail of 1 px",
    "road_detail_2": "road: detail of 2 px",
    "noise_dark": "noise of plain dark areas",
    "noise_bright": "noise of plain bright areas",
    "blue_to_green": "blue / green",
    "red_to_green": "red / green",
    "colourfulness": "mean distance from grey",
}
"""What is measured; grey values of 0 to 255 where nothing else stands."""

_SCALES = {"half": 0.5, "1": 1.0, "2": 2.0, "4": 4.0}
_BLOCK = 12
_DARK, _BRIGHT = (25.0, 75.0), (100.0, 200.0)
_NOISE = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32) / 6.0
"""Passes white noise at its strength and takes away edges and slopes (Immerkaer 1996)."""


@dataclass(frozen=True)
class ImageNumbers:
    """A rendered image in numbers, see `QUANTITIES`; what is not known is None."""

    values: Mapping[str, float | None]


@dataclass(frozen=True)
class ImageQuantity:
    """Mean and standard deviation of a quantity over rendered and over real images."""

    title: str
    ours: tuple[float, float] | None
    real: tuple[float, float] | None


@dataclass(frozen=True)
class ImageComparison:
    """Rendered images beside real ones."""

    frames: int
    real_frames: list[str]
    quantities: Mapping[str, ImageQuantity]
    """Quantities by the names of `QUANTITIES`."""


def statistics(image: Image) -> dict[str, float]:
    """An image in numbers, see `QUANTITIES`.

    The road is what lies in the middle of the lowest sixth: nearly always only road.

    Args:
        image: Shape (H, W, 3).
    """
    import cv2

    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY).astype(np.float32)
    height, width = grey.shape
    road = np.s_[height * 5 // 6 :, width * 2 // 5 : width * 3 // 5]
    low, middle, high = np.percentile(grey, [5, 50, 95])
    red, green, blue = image.reshape(-1, 3).mean(axis=0)
    found = {
        "mean": grey.mean(),
        "deviation": grey.std(),
        "p5": low,
        "p50": middle,
        "p95": high,
        "saturated": 100.0 * (grey > 250).mean(),
        "dark": 100.0 * (grey < 25).mean(),
        "road_mean": grey[road].mean(),
        "blue_to_green": blue / green,
        "red_to_green": red / green,
        "colourfulness": np.abs(image - image.mean(axis=2, keepdims=True)).mean(),
    }
    sharper: Float32s = grey
    for name, deviation in _SCALES.items():
        blurred = np.asarray(cv2.GaussianBlur(grey, (0, 0), deviation), np.float32)
        band = sharper - blurred
        found[f"detail_{name}"] = band.std()
        found[f"road_detail_{name}"] = band[road].std()
        sharper = blurred
    plain = cv2.filter2D(image[..., 1].astype(np.float32), -1, _NOISE)
    level, noise = (_blocks(values) for values in (image[..., 1].astype(np.float32), plain))
    for name, (above, below) in {"dark": _DARK, "bright": _BRIGHT}.items():
        mean = level.mean(axis=1)
        there = noise[(mean > above) & (mean < below)].std(axis=1)
        found[f"noise_{name}"] = np.percentile(there, 5) if len(there) else np.nan
    return {name: round(float(found[name]), 4) for name in QUANTITIES}


def _blocks(values: np.ndarray) -> np.ndarray:
    """Square blocks of a map, shape (n, pixels)."""
    height, width = (size // _BLOCK for size in values.shape)
    cut = values[: height * _BLOCK, : width * _BLOCK]
    parts = cut.reshape(height, _BLOCK, width, _BLOCK).transpose(0, 2, 1, 3)
    return np.asarray(parts.reshape(-1, _BLOCK**2))


def measure(posed: PosedScene, capture: Capture) -> ImageNumbers:
    """The measures of a rendered frame's left colour image."""
    return _known(statistics(capture.images[2]))


def real_images(kitti: Path) -> dict[str, ImageNumbers]:
    """Real left colour images, by frame.

    Raises:
        DataError: A file is broken.
    """
    nested = kitti / "object"
    data = KittiObject(nested if nested.is_dir() else kitti)
    ids = data.ids(having=("image_2", "calib"))
    return {id: _known(statistics(data.frame(id).image(2))) for id in ids}


def _known(values: Mapping[str, float]) -> ImageNumbers:
    return ImageNumbers({name: None if np.isnan(v) else v for name, v in values.items()})


def summary(rows: Sequence[ImageNumbers], real: Mapping[str, ImageNumbers]) -> ImageComparison:
    """Mean and spread of both.

    Args:
        rows: The rows of `measure`.
        real: The result of `real_images`.
    """
    quantities = {
        name: ImageQuantity(
            title,
            ours=_mean_and_spread([row.values[name] for row in rows]),
            real=_mean_and_spread([row.values[name] for row in real.values()]),
        )
        for name, title in QUANTITIES.items()
    }
    return ImageComparison(len(rows), sorted(real), quantities)


def _mean_and_spread(values: Sequence[float | None]) -> tuple[float, float] | None:
    known = [value for value in values if value is not None]
    return (float(np.mean(known)), float(np.std(known))) if known else None


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write JSON; returns the exit code."""
    return command(
        __doc__,
        arguments,
        lambda options: summary(
            measure_one(options, measure), real_images(options.kitti) if options.kitti else {}
        ),
    )


if __name__ == "__main__":
    sys.exit(main())
