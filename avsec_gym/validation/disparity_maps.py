"""`DisparityMaps`: the maps DM_{i,k} of one moment (thesis, section 3.3)."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.depth.depth import DisparityMap, pair_scale
from avsec_gym.perception.depth.lidar import scan_disparity
from avsec_gym.sensor_system import LIDAR, SensorSystem
from avsec_gym.validation.brightness import brightness_inconsistency
from avsec_gym.validation.pair_depth import PairDepth

Pair = tuple[int, int]
"""Positions i < k in a system: what sensor i tells of the view of camera k."""


class DisparityMaps:
    """DM_{i,k} of all pairs of a system; each is found when first asked for, and kept.

    Args:
        frame: The moment.
        system: Which sensors, in which order.
        depth: How disparities of two cameras are found.

    Raises:
        ConfigurationError: The cameras do not stand from right to left.

    Example:
        >>> maps = DisparityMaps(frame, KITTI_SYSTEM)  # doctest: +SKIP
        >>> maps[0, 3].values.shape  # doctest: +SKIP
        (375, 1242)
    """

    def __init__(
        self, frame: SensorFrame, system: SensorSystem, depth: PairDepth | None = None
    ) -> None:
        system.check(frame.calibration)
        self.frame, self.system, self.depth = frame, system, depth or PairDepth()
        self._found: dict[Pair, DisparityMap] = {}
        self._brightness: dict[Pair, float] = {}

    def __getitem__(self, pair: Pair) -> DisparityMap:
        """DM_{i,k}, in the scale of the two cameras; a LiDAR's in that of (k - 1, k).

        Raises:
            ConfigurationError: The system has no such pair.
            DataError: The frame lacks a sensor, or its file is broken.
        """
        if pair not in self._found:
            self._found[pair] = self._find(pair)
        return self._found[pair]

    def brightness(self, pair: Pair) -> float:
        """`brightness_inconsistency` of two cameras, matched by DM_{i,k}.

        Raises:
            ConfigurationError: The system has no such pair, or one of them is the LiDAR.
            DataError: The frame lacks a sensor, or its file is broken.
        """
        if pair not in self._brightness:
            values = self[pair].values
            other, camera = (self.system.sensors[one] for one in pair)
            if not isinstance(other, int):
                raise ConfigurationError("a LiDAR sees no brightness to be compared")
            self._brightness[pair] = brightness_inconsistency(
                self.frame.image(int(camera)), self.frame.image(other), values
            )
        return self._brightness[pair]

    def find(self, pairs: Iterable[Pair], threads: int = 2) -> None:
        """Find several maps at once; OpenCV's matching runs outside Python's lock."""
        missing = [pair for pair in dict.fromkeys(pairs) if pair not in self._found]
        with ThreadPoolExecutor(threads) as pool:
            self._found.update(zip(missing, pool.map(self._find, missing), strict=True))

    def _find(self, pair: Pair) -> DisparityMap:
        i, k = pair
        sensors, frame = self.system.sensors, self.frame
        if not 0 <= i < k < len(sensors) or k < 2:
            raise ConfigurationError(
                f"a disparity map belongs to positions i < k with k from 2 to {len(sensors) - 1}, "
                f"got {pair}"
            )
        other, camera = sensors[i], int(sensors[k])
        if other != LIDAR:
            return self.depth.estimator(frame.calibration, camera, int(other)).disparity(frame)
        beside = int(sensors[k - 1])
        height, width = frame.image(camera).shape[:2]
        values = scan_disparity(frame.points, frame.calibration, (height, width), (camera, beside))
        return DisparityMap(values, pair_scale(frame, camera, beside))
