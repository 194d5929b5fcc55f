"""`SensorSystem`: the sensors that check each other, in the thesis' order (section 3.4).

S_0 is the LiDAR where there is one; cameras follow from right to left, so that every camera can be
the left one, hence the reference, of a stereo pair with each sensor before it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration

LIDAR = "lidar"
Sensor = int | str
"""A camera's number, or `LIDAR`."""
Triple = tuple[int, int, int]
"""Positions i < j < k in a system: the disparity maps of i and j, both seen by the camera k."""
MOST_SENSORS = 16
"""An attacker can choose any of their subsets; of more sensors these are too many to list."""


@dataclass(frozen=True)
class SensorSystem:
    """Three sensors or more that see the same scene.

    Args:
        sensors: S_0 to S_n, `MOST_SENSORS` at most: the LiDAR first, if there is one, then cameras
            from right to left.

    Raises:
        ConfigurationError: Too few or too many sensors, one of them twice, a LiDAR that is not the
            first, or something that is no sensor.

    Example:
        >>> SensorSystem(("lidar", 3, 2)).reference
        2
    """

    sensors: tuple[Sensor, ...]

    def __post_init__(self) -> None:
        if isinstance(self.sensors, str) or not isinstance(self.sensors, Sequence):
            raise ConfigurationError(
                f"sensors are a list such as ({LIDAR!r}, 3, 2), got {self.sensors!r}"
            )
        sensors = tuple(self.sensors)
        object.__setattr__(self, "sensors", sensors)
        listed = ", ".join(map(str, sensors[: MOST_SENSORS + 1]))
        if not 3 <= len(sensors) <= MOST_SENSORS:
            raise ConfigurationError(
                f"a system has 3 to {MOST_SENSORS} sensors, got {len(sensors)}: {listed}"
            )
        for position, sensor in enumerate(sensors):
            if isinstance(sensor, bool) or not (
                (isinstance(sensor, int) and sensor >= 0) or (sensor == LIDAR and position == 0)
            ):
                raise ConfigurationError(
                    f"sensors are cameras' numbers, and {LIDAR!r} for the first, got {sensor!r} as "
                    f"S{position}"
                )
        if len(set(sensors)) != len(sensors):
            raise ConfigurationError(f"the sensors of a system are different ones, got {listed}")

    def __len__(self) -> int:
        return len(self.sensors)

    @property
    def has_lidar(self) -> bool:
        """Whether S_0 is a LiDAR."""
        return self.sensors[0] == LIDAR

    @property
    def cameras(self) -> tuple[int, ...]:
        """The cameras from right to left."""
        return tuple(sensor for sensor in self.sensors if isinstance(sensor, int))

    @property
    def reference(self) -> int:
        """S_n, the leftmost camera."""
        return self.cameras[-1]

    @property
    def triples(self) -> tuple[Triple, ...]:
        """All (i, j, k) with i < j < k; k is a camera that i and j are compared in.

        Algorithm 1 uses those with k = n; the recursion of algorithm 2 reaches smaller k.
        """
        return tuple(combinations(range(len(self)), 3))

    def has_scan(self, positions: tuple[int, ...]) -> bool:
        """Whether the LiDAR is among some sensors, in ascending order."""
        return self.has_lidar and positions[0] == 0

    def pairs_of(self, triple: Triple) -> tuple[tuple[int, int], ...]:
        """Positions (i, k), i < k, whose disparity maps DM_{i,k} a triple compares.

        Of depth those in its reference alone; of brightness all between two of its cameras.
        """
        i, j, k = triple
        return ((i, k), (j, k)) if self.has_scan(triple) else ((i, j), (i, k), (j, k))

    def pairs(self, reference: int | None = None) -> list[tuple[int, int]]:
        """`pairs_of` all triples, or of those of one reference, by their references."""
        triples = [triple for triple in self.triples if reference in (None, triple[2])]
        found = {pair for triple in triples for pair in self.pairs_of(triple)}
        return sorted(found, key=lambda pair: pair[::-1])

    def check(self, calibration: Calibration) -> None:
        """Check that the cameras stand in the order of the system.

        Raises:
            ConfigurationError: A camera is not calibrated, or is not left of the one before it.
        """
        for right, left in zip(self.cameras, self.cameras[1:], strict=False):
            if calibration.baseline(left, right) <= 0:
                raise ConfigurationError(
                    f"cameras are named from right to left, but camera {left} is "
                    f"{-calibration.baseline(left, right):.2f} m right of camera {right}"
                )


def sensor_name(sensor: Sensor) -> str:
    """A sensor in a sentence.

    Example:
        >>> sensor_name(2), sensor_name("lidar")
        ('camera 2', 'the LiDAR')
    """
    return "the LiDAR" if sensor == LIDAR else f"camera {sensor}"


KITTI_SYSTEM = SensorSystem((LIDAR, 1, 3, 2))
"""KITTI's with camera 2 as the reference; camera 0 stands 6 cm from it, and 1 and 3 stand 7 cm from
each other, so that they can check each other little."""
