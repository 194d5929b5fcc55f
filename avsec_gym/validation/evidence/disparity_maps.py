"""`DisparityMaps`: the maps DM_{i,k} of one frame (thesis, section 3.3)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.depth.depth import DisparityMap, pair_scale
from avsec_gym.perception.depth.lidar import scan_disparity
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.evidence.brightness import (
    Brightness,
    brightness_inconsistency,
    is_grey,
    without_colours,
)
from avsec_gym.validation.evidence.pair_depth import PairDepth

Pair = tuple[int, int]
"""Positions i < k in a system: what sensor i measures in the view of camera k."""


class PairView(NamedTuple):
    """What two sensors measure in the view of the second one."""

    map: DisparityMap
    """DM_{i,k}, in the scale of the two cameras; a LiDAR's in that of (k - 1, k)."""
    brightness: Brightness | None
    """The brightness of two cameras, matched by the map."""


class DisparityMaps:
    """DM_{i,k} of all pairs of a system; each is found when first asked for, and kept.

    Args:
        frame: The frame.
        system: The sensors, in their order.
        depth: How disparities of two cameras are found.
        known: What is known of the frame already.

    Raises:
        ConfigurationError: The cameras do not stand from right to left.

    Example:
        >>> maps = DisparityMaps(frame, KITTI_SYSTEM)  # doctest: +SKIP
        >>> maps[0, 3].values.shape  # doctest: +SKIP
        (375, 1242)
    """

    def __init__(
        self,
        frame: SensorFrame,
        system: SensorSystem,
        depth: PairDepth | None = None,
        known: Mapping[Pair, PairView] | None = None,
    ) -> None:
        system.check(frame.calibration)
        self.frame, self.system, self.depth = frame, system, depth or PairDepth()
        self._known = dict(known or {})

    def __getitem__(self, pair: Pair) -> DisparityMap:
        """DM_{i,k}, see `PairView`.

        Raises:
            ConfigurationError: The system has no such pair.
            DataError: The frame lacks a sensor, or its file is broken.
        """
        return self.view(pair).map

    def view(self, pair: Pair) -> PairView:
        """The map and the brightness of a pair; raises as the map does."""
        if pair not in self._known:
            self._known[pair] = self._find(pair)
        return self._known[pair]

    def brightness(self, pair: Pair) -> Brightness:
        """`brightness_inconsistency` of two cameras, matched by DM_{i,k}.

        Raises:
            ConfigurationError: The system has no such pair, or one of them is the LiDAR.
            DataError: The frame lacks a sensor, or its file is broken.
        """
        brightness = self.view(pair).brightness
        if brightness is None:
            raise ConfigurationError("a LiDAR sees no brightness to be compared")
        return brightness

    def find(self, pairs: Iterable[Pair], threads: int = 2) -> None:
        """Find several maps at once.

        Args:
            pairs: The pairs; those that are known cost nothing.
            threads: OpenCV works outside Python's lock.
        """
        missing = [self._checked(pair) for pair in dict.fromkeys(pairs) if pair not in self._known]
        if missing:
            # The longest work first, so that no thread is left alone with it.
            missing.sort(key=self._work, reverse=True)
            with ThreadPoolExecutor(threads) as pool:
                list(pool.map(self.view, missing))

    def _checked(self, pair: Pair) -> Pair:
        if pair not in (known := self.system.pairs()):
            raise ConfigurationError(f"the disparity maps are those of {known}, got {pair}")
        return pair

    def _work(self, pair: Pair) -> float:
        """Cameras that stand farther apart are matched longer; a scan is quick."""
        if self.system.has_scan(pair):
            return 0.0
        other, camera = (int(self.system.sensors[position]) for position in pair)
        return self.frame.calibration.baseline(camera, other)

    def _find(self, pair: Pair) -> PairView:
        i, k = self._checked(pair)
        sensors, frame = self.system.sensors, self.frame
        other, camera = sensors[i], int(sensors[k])
        if other != LIDAR:
            return self._between(camera, int(other))
        beside = int(sensors[k - 1])
        height, width = frame.image(camera).shape[:2]
        values = scan_disparity(frame.points, frame.calibration, (height, width), (camera, beside))
        return PairView(DisparityMap(values, pair_scale(frame, camera, beside)), None)

    def _between(self, camera: int, right: int) -> PairView:
        frame = self.frame
        images = {number: frame.image(number) for number in (camera, right)}
        if len({is_grey(image) for image in images.values()}) > 1:
            # To a network, a grey image and one of colours are two scenes.
            images = {number: without_colours(image) for number, image in images.items()}
            for number, image in images.items():
                frame = frame.with_image(number, image)
        found = self.depth.estimator(frame.calibration, camera, right).disparity(frame)
        return PairView(
            found, brightness_inconsistency(images[camera], images[right], found.values)
        )
