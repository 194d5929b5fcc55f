"""The work behind figure 5.8: one detector, one patch, on noise or on scenes; rows by layer."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path

from avsec_gym.attacks.attack import LEFT
from avsec_gym.attacks.patch_files import Patch, load_patch
from avsec_gym.experiments.chapter5.attacked_cells import attacked_inputs
from avsec_gym.experiments.chapter5.feature_spread import (
    LAYERS,
    FeatureSpread,
    SpreadExtent,
    feature_spread,
)
from avsec_gym.experiments.chapter5.scenes import PYRAMID_OPTIONS, scenes_of
from avsec_gym.experiments.chapter5.settings import DETECTORS, WITHOUT_PYRAMID, setting
from avsec_gym.experiments.chapter5.trained import (
    TRAINED_PATCHES,
    patch_file,
    patches_there,
    trained_detector,
)
from avsec_gym.experiments.json_rows import FLAT
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.detectors.detector import Detector
from avsec_gym.perception.stereo_batch import StereoBatch, batch_of_frames
from avsec_gym.runs.experiment import Cell, CellResult, Configuration, Measurement
from avsec_gym.runs.results import Results

NOISE = "noise"
"""A patch of noise, the control; and images of noise."""
SCENES = "scenes"
PATCHES = (*TRAINED_PATCHES, NOISE)
IMAGES = (NOISE, SCENES)
QUANTITIES = tuple(quantity.name for quantity in fields(SpreadExtent))
"""Names of the figures of each layer."""

_WORK = "avsec_gym.experiments.chapter5.patch_spreads:PatchSpreads"
_BATCH = 4
"""Images that maps are averaged over."""
_PATCH_RADIUS = "patch radius"


def spread_cells(
    configuration: Configuration, detectors: Sequence[str] | None = None
) -> list[Cell]:
    """A cell for every detector, patch and kind of images.

    Patches without a file are left out, and scenes where there is only one.

    Args:
        configuration: The configuration of the run.
        detectors: The detectors; None: `spread_detectors`.
    """
    options = {**PYRAMID_OPTIONS, **configuration.options}
    images = IMAGES if len(scenes_of(configuration)) > 1 else IMAGES[:1]
    return [
        Cell.of(_WORK, detector, detector=detector, patch=patch, images=each)
        for detector in detectors or spread_detectors(configuration)
        for patch in (*patches_there(detector, options), NOISE)
        for each in images
    ]


def spread_inputs(configuration: Configuration) -> dict[str, Path]:
    """Weights, patches and the images' manifests."""
    return attacked_inputs(configuration, spread_detectors(configuration))


def spread_detectors(configuration: Configuration) -> tuple[str, ...]:
    """The detectors of the chapter, and DSGN without its pyramid where weights are given."""
    given = configuration.options.get(WITHOUT_PYRAMID)
    return (*DETECTORS, WITHOUT_PYRAMID) if given else DETECTORS


@dataclass(frozen=True)
class SpreadRow:
    """How far a patch spreads in one layer.

    Args:
        detector: The detector.
        patch: One of `PATCHES`.
        images: One of `IMAGES`.
        layer: The thesis' name of the layer.
        patch_radius: Radius of the patch, pixels.
        extent: How far it spreads.
    """

    detector: str
    patch: str
    images: str
    layer: str
    patch_radius: float
    extent: SpreadExtent = field(metadata=FLAT)


def spread_rows(results: Results) -> list[SpreadRow]:
    """Figure 5.8 in numbers: of each detector, patch, kind of images and layer, what spreads."""
    found: dict[str, dict[str, float]] = defaultdict(dict)
    for row in results.measurements(scenario=""):
        found[row.setting][row.name] = row.value
    return [
        SpreadRow(
            *(detector, patch, images, layer),
            numbers[_PATCH_RADIUS],
            SpreadExtent(*(numbers[f"{layer} {quantity}"] for quantity in QUANTITIES)),
        )
        for detector in (*DETECTORS, WITHOUT_PYRAMID)
        for patch in PATCHES
        for images in IMAGES
        for numbers in [found.get(spread_setting(detector, patch, images), {})]
        for layer in LAYERS
        if f"{layer} {QUANTITIES[0]}" in numbers
    ]


def spread_setting(detector: str, patch: str, images: str) -> str:
    """The setting of measurements."""
    return setting(detector, f"spread-{patch}-{images}")


class PatchSpreads:
    """Follows patches through detectors; see `avsec_gym.runs.experiment.Work`.

    Args:
        configuration: The configuration of the run.
    """

    def __init__(self, configuration: Configuration) -> None:
        self._configuration = configuration
        self._options = {**PYRAMID_OPTIONS, **configuration.options}
        self._detectors: dict[str, Detector] = {}

    def __call__(self, detector: str, patch: str, images: str) -> CellResult:
        """The results of one cell.

        Args:
            detector: The detector's name.
            patch: One of `PATCHES`.
            images: One of `IMAGES`.

        Raises:
            ConfigurationError: The scenes' images are too small, or no two of one size.
            DataError: A file is missing or broken.
        """
        start = time.perf_counter()
        spread = self.spread(detector, patch, images)
        numbers = {_PATCH_RADIUS: spread.patch_radius}
        for layer in spread.layers:
            numbers |= {
                f"{layer.layer} {quantity}": value for quantity, value in vars(layer.extent).items()
            }
        filed = spread_setting(detector, patch, images)
        return CellResult(
            measurements=[Measurement(filed, "", name, value) for name, value in numbers.items()],
            seconds={"spread": time.perf_counter() - start},
        )

    def spread(self, detector: str, patch: str, images: str) -> FeatureSpread:
        """The maps themselves, which a run does not keep; arguments and errors as above."""
        if detector not in self._detectors:
            self._detectors[detector] = trained_detector(detector, self._options)
        return feature_spread(
            self._detectors[detector],
            self._patch(patch, detector),
            self._configuration.seed,
            scenes=None if images == NOISE else self._scenes(),
            images=_BATCH,
        )

    def _patch(self, kind: str, detector: str) -> Patch:
        if kind == NOISE:
            return Patch.noise(self._configuration.seed)
        return load_patch(patch_file(kind, detector, self._options))

    def _scenes(self) -> StereoBatch:
        """The first scenes with images of one size."""
        scenes = scenes_of(self._configuration)
        by_size: dict[tuple[int, ...], list[SensorFrame]] = defaultdict(list)
        for scene in scenes.scenes.labelled:
            frame = scenes.frame(scene)
            same = by_size[frame.image(LEFT).shape]
            same.append(frame)
            if len(same) == _BATCH:
                return batch_of_frames(same)
        return batch_of_frames(max(by_size.values(), key=len))
