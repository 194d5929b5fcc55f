"""Pictures of figure 5.8: feature maps that a patch changes, made again from a run's settings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import matplotlib
import numpy as np

from avsec_gym.drawing.embedded_image import embedded
from avsec_gym.experiments.chapter5.attack_names import detector_name
from avsec_gym.experiments.chapter5.feature_spread import FeatureSpread
from avsec_gym.experiments.chapter5.patch_spreads import IMAGES, SpreadRow
from avsec_gym.experiments.chapter5.section.tables_why import IMAGE_WORDS, PATCH_WORDS
from avsec_gym.geometry import Floats
from avsec_gym.progress import Progress, no_progress

_BEST = ("joint", "patch", "noise")
"""The thesis' figure is of the joint patch."""


class Spreads(Protocol):
    """The part of `avsec_gym.experiments.chapter5.patch_spreads.PatchSpreads` needed here."""

    def spread(self, detector: str, patch: str, images: str) -> FeatureSpread:
        """The maps of one cell."""
        ...


@dataclass(frozen=True)
class MapPicture:
    """One layer.

    Args:
        layer: The layer's name.
        image: The map as a data URI, from no change to the layer's largest.
        radius: The radius that changes by the layer's maximum, in multiples of the patch's.
        radius_absolute: The radius by what another image would change, likewise.
    """

    layer: str
    image: str
    radius: float
    radius_absolute: float


@dataclass(frozen=True)
class SpreadPicture:
    """A row of maps.

    Args:
        title: Detector, patch and images.
        image: What the left camera sees, as a data URI.
        maps: The maps from shallow to deep.
    """

    title: str
    image: str
    maps: tuple[MapPicture, ...]


def shown_spreads(
    rows: Sequence[SpreadRow],
    spreads: Spreads,
    on_progress: Progress = no_progress,
) -> dict[str, FeatureSpread]:
    """Maps by their titles: of each detector one patch, on noise and on scenes.

    Args:
        rows: The spread in each layer.
        spreads: The work that makes the maps.
        on_progress: Function that gets the number of maps that are done, and of all.

    Raises:
        DataError: Weights, patches or scenes are no longer there.
    """
    wanted = list(_wanted(rows))
    found = {}
    for number, (detector, patch, images) in enumerate(wanted, start=1):
        title = f"{detector_name(detector)}, {PATCH_WORDS[patch]} {IMAGE_WORDS[images]}"
        found[title] = spreads.spread(detector, patch, images)
        on_progress(number, len(wanted))
    return found


def spread_picture(title: str, spread: FeatureSpread) -> SpreadPicture:
    """What a page shows of it."""
    maps = [
        MapPicture(
            layer.layer,
            _coloured(layer.difference),
            layer.extent.radius / spread.patch_radius,
            layer.extent.radius_absolute / spread.patch_radius,
        )
        for layer in spread.layers
    ]
    image = np.rint(255 * np.clip(spread.image, 0, 1)).astype(np.uint8)
    return SpreadPicture(title, embedded(image), tuple(maps))


def _wanted(rows: Sequence[SpreadRow]) -> Iterator[tuple[str, str, str]]:
    there = {(row.detector, row.patch, row.images) for row in rows}
    for images in IMAGES:
        for detector in dict.fromkeys(row.detector for row in rows):
            patches = [patch for patch in _BEST if (detector, patch, images) in there]
            if patches:
                yield detector, patches[0], images


def _coloured(values: Floats) -> str:
    share = values / max(float(values.max()), 1e-12)
    colours = matplotlib.colormaps["inferno"](share)[..., :3]
    return embedded(np.rint(255 * colours).astype(np.uint8))
