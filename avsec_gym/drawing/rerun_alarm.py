"""An alarm of a vehicle's own sensors as a recording: what they saw, and where they are damaged."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from avsec_gym.drawing.rerun_stream import colour, log_camera, log_points, recording
from avsec_gym.drawing.validation_picture import damage_in_words, named
from avsec_gym.sensor_system import LIDAR, Sensor
from avsec_gym.validation.validator import Validation

if TYPE_CHECKING:
    from avsec_gym.validation.repair.damage import Damage

_DAMAGE = "#FF00FF"


def write_alarm_recording(
    validation: Validation,
    path: Path,
    damage: Mapping[Sensor, Damage] | None = None,
    origin: str = "",
) -> None:
    """Write the sensors of a validated frame, in the velodyne frame, with their status in words.

    Damaged pixels lie over their image as a segmentation of one class, damaged points are magenta.

    Args:
        validation: Validation of one frame.
        path: The file, ``.rrd``; one that is there is replaced.
        damage: Damage by sensor, for the sensors where it was looked for.
        origin: Data that the validator was fitted on, in words.

    Raises:
        ConfigurationError: Rerun's SDK is not installed.
    """
    maps = validation.errors.maps
    system, frame = maps.system, maps.frame
    words = ["alarm" if validation.alarm else "no alarm"]
    with recording(path, f"validation of {frame.id}") as stream:
        import rerun as rr

        stream.log("/", rr.ViewCoordinates.FLU, static=True)
        for sensor in system.sensors:
            found = (damage or {}).get(sensor)
            words.append(f"- {named(sensor)}: {validation.statuses[sensor]}")
            if validation.probabilities is not None:
                words[-1] += f", P(attacked) = {validation.probabilities[sensor]:.3f}"
            if found is not None:
                words[-1] += f", {damage_in_words(found.row)}"
            if sensor == LIDAR:
                log_points(stream, "lidar", frame.points)
                if found is not None and found.scan is not None:
                    bogus = frame.points[found.scan.points, :3]
                    points = rr.Points3D(bogus, colors=[colour(_DAMAGE)], radii=0.08)
                    stream.log("lidar/damage", points)
                continue
            entity = f"camera_{sensor}"
            log_camera(stream, entity, frame.image(int(sensor)), frame.calibration, int(sensor))
            if found is not None and found.pixels is not None:
                stream.log(
                    f"{entity}/damage", rr.AnnotationContext([(1, "damage", colour(_DAMAGE))])
                )
                mask = found.pixels.astype(np.uint8)
                stream.log(f"{entity}/damage", rr.SegmentationImage(mask))
        if origin:
            words.append(f"\nwhat decides here was {origin}")
        text = "\n".join(words)
        stream.log("status", rr.TextDocument(text, media_type=rr.MediaType.MARKDOWN))
