"""What of a frame a car's perception reads, so that nothing else is rendered."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.sensor_system import LIDAR, Sensor


@dataclass(frozen=True)
class SensorNeeds:
    """What is rendered.

    Args:
        cameras: Numbers of the cameras.
        scan: Whether the LiDAR scans.
        width: Width of the images, pixels; None: the rig's own.
    """

    cameras: tuple[int, ...] = (2, 3)
    scan: bool = True
    width: int | None = None

    @property
    def sensors(self) -> frozenset[Sensor]:
        """The sensors that are rendered."""
        return frozenset((*self.cameras, *([LIDAR] if self.scan else [])))


def width_read(detector: Any) -> int | None:
    """The width that a detector resizes images to, pixels; None: it reads them as they are.

    Args:
        detector: A live detector.
    """
    size = getattr(getattr(detector, "configuration", None), "input_size", None)
    return None if size is None else int(size[1])


def sensing(scene: TrafficScene, needs: SensorNeeds) -> TrafficScene:
    """A scene whose sensors deliver what is needed; sensors that are not rendered stay.

    Args:
        scene: The scene.
        needs: What the perception reads.
    """
    sensors = scene.sensors
    if sensors is None or needs == SensorNeeds():
        return scene
    # Cars that know the truth need no renderer.
    from avsec_gym.closed_loop.rendered_sensors import RenderedSensors
    from avsec_gym.world.capture import Lidar

    if not isinstance(sensors, RenderedSensors):
        return scene
    return replace(
        scene,
        sensors=replace(
            sensors,
            cameras=needs.cameras,
            lidar=(sensors.lidar or Lidar()) if needs.scan else None,
            width=needs.width,
        ),
    )
