"""A picture of an alarm: what the sensors saw, where they are damaged or contradict each other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from avsec_gym.drawing.frame_picture import points_in_image
from avsec_gym.frame import Image, SensorFrame
from avsec_gym.geometry import project, transform_points
from avsec_gym.sensor_system import LIDAR, Sensor, Triple
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.validation.evidence.comparison import Comparison, comparison_map
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.validation.validator import SHARES, Validation

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from avsec_gym.validation.repair.damage import Damage

_COLOURS = {Comparison.INCONSISTENT: (215, 38, 61), Comparison.CONSISTENT: (60, 160, 110)}
_HOLE = (70, 110, 220)
_DAMAGE = (255, 0, 255)
_LEGEND = (
    "left: damage is magenta        "
    "right: red inconsistent, green consistent, blue unknown to one of the two"
)
_NEAR, _FAR_OUT = 0.5, 5000
"""Metres before a camera; pixels, which OpenCV can still count."""
_MOST_TRIPLES = 6
_MARKS = {
    SensorStatus.ATTACKED: "#D7263D",
    SensorStatus.CANNOT_TELL: "#B8860B",
    SensorStatus.SOUND: "#222222",
}


def draw_validation(
    validation: Validation, damage: Mapping[Sensor, Damage] | None = None, origin: str = ""
) -> Figure:
    """Left: the sensors with their status.  Right: triples.

    Triples whose shares raised the alarm come first, then those of the reference, six at most.
    Left, what is damaged is magenta.  Right, red: inconsistent pixels; green: consistent ones;
    blue: holes that one of two maps has; beside each share its threshold, if there is one.

    Args:
        validation: Validation of one frame.
        damage: Damage by sensor, for the sensors where it was looked for.
        origin: Data that the validator was fitted on, in words.
    """
    from matplotlib.figure import Figure

    system, triples = validation.errors.maps.system, _triples_to_show(validation)
    rows = max(len(system), len(triples))
    figure = Figure(
        figsize=(12, 0.3 + 2.3 * rows), dpi=100, facecolor="white", layout="constrained"
    )
    figure.suptitle(_LEGEND, fontsize=9, x=0.99, ha="right")
    if origin:
        figure.supxlabel(f"what decides here was {origin}", fontsize=9, x=0.99, ha="right")
    panels = figure.subplots(rows, 2, squeeze=False)
    for axes in panels.flat:
        axes.set_axis_off()
    for axes, sensor in zip(panels[:, 0], system.sensors, strict=False):
        _draw_sensor(axes, validation, sensor, (damage or {}).get(sensor))
    for axes, triple in zip(panels[:, 1], triples, strict=False):
        _draw_triple(axes, validation, triple)
    return figure


def _triples_to_show(validation: Validation) -> list[Triple]:
    """Those that raised the alarm, then those of the reference."""
    known = validation.errors.known
    last = max((k for _, _, k in known), default=len(validation.errors.maps.system) - 1)
    beyond = {comparison.triple: None for comparison in validation.exceeded}
    others = (each for each in sorted(known) if each[2] == last and each not in beyond)
    return [*beyond, *others][:_MOST_TRIPLES]


def _draw_sensor(axes: Axes, validation: Validation, sensor: Sensor, damage: Damage | None) -> None:
    """What a sensor sees, its damage marked, under its status."""
    system, frame = validation.errors.maps.system, validation.errors.maps.frame
    status = validation.statuses[sensor]
    title = f"{named(sensor)}: {status}"
    if damage is not None:
        title += f", {damage_in_words(damage.row)}"
    if validation.probabilities is not None:
        title += f", P(attacked) = {validation.probabilities[sensor]:.3f}"
    camera = system.reference if sensor == LIDAR else int(sensor)
    image = frame.image(camera)
    if sensor == LIDAR:
        image = points_in_image(image, frame, camera)
    axes.imshow(image if damage is None else _marked(image, damage, frame, camera))
    axes.set_title(title, loc="left", fontsize=9, color=_MARKS[status])


def _draw_triple(axes: Axes, validation: Validation, triple: Triple) -> None:
    """Where the two maps of a triple agree, under its shares."""
    maps = validation.errors.maps
    sensors = maps.system.sensors
    i, j, k = triple
    compared = comparison_map(maps[i, k], maps[j, k])
    image = maps.frame.image(int(sensors[k]))
    axes.imshow(compared_picture(image, compared, sensors[i] == LIDAR))
    raised = any(comparison.triple == triple for comparison in validation.exceeded)
    axes.set_title(
        f"{compared_in_words([sensors[number] for number in triple])}\n"
        + _shares_in_words(validation, triple),
        loc="left",
        fontsize=9,
        color=_MARKS[SensorStatus.ATTACKED if raised else SensorStatus.SOUND],
    )


def save_validation_picture(
    validation: Validation,
    path: Path,
    damage: Mapping[Sensor, Damage] | None = None,
    origin: str = "",
) -> None:
    """Write it as PNG, over one that is there; see `draw_validation`."""
    import io

    content = io.BytesIO()
    draw_validation(validation, damage, origin).savefig(content, format="png")
    write_bytes(path, content.getvalue(), overwrite=True)


def compared_in_words(sensors: Sequence[Sensor]) -> str:
    """A triple's comparison in words: ``LiDAR against camera 3, seen by camera 2``."""
    return "{} against {}, seen by {}".format(*map(named, sensors))


def damage_in_words(row: Mapping[str, Any]) -> str:
    """`Damage.row` in words: ``12 % of its pixels``."""
    if "unknown" in row:
        return "too few sensors are sound to locate it"
    words = []
    if share := row.get("share_of_pixels"):
        words.append(f"{100 * share:.1f} % of its pixels")
    if points := row.get("points"):
        words.append(f"{points} points")
    if lost := row.get("lost_directions"):
        words.append(f"{lost} directions lost")
    return ", ".join(words) or "no damage found"


def named(sensor: Sensor) -> str:
    """A sensor's name in words: ``LiDAR``, ``camera 3``."""
    return "LiDAR" if sensor == LIDAR else f"camera {sensor}"


def _shares_in_words(validation: Validation, triple: Triple) -> str:
    """Two lines; a share that is beyond its threshold is ``>``."""
    words = []
    for share, name in SHARES.items():
        value = getattr(validation.errors[triple], share)
        words.append(f"{name} {value:.3g}")
        if validation.thresholds is not None:
            threshold = getattr(validation.thresholds[triple], share)
            if np.isfinite(threshold):
                words[-1] += f" {'>' if value > threshold else '≤'} {threshold:.3g}"
    return "{}, {}\n{}, {}".format(*words)


def _marked(image: Image, damage: Damage, frame: SensorFrame, camera: int) -> Image:
    """Damaged pixels of a camera outlined and tinted; damaged points of a scan in its view."""
    import cv2

    result: Any = image.copy()
    if damage.pixels is not None:
        result[damage.pixels] = 0.8 * result[damage.pixels] + 0.2 * np.array(_DAMAGE)
        outlines, _ = cv2.findContours(
            damage.pixels.astype(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE
        )
        cv2.drawContours(result, outlines, -1, _DAMAGE, max(1, image.shape[1] // 300))
    if damage.scan is not None:
        bogus = frame.points[damage.scan.points, :3]
        places = transform_points(frame.calibration.velodyne_to_camera, bogus)
        pixels, ahead = project(frame.calibration.projection(camera), places)
        for u, v in pixels[ahead > _NEAR].clip(-_FAR_OUT, _FAR_OUT).astype(int).tolist():
            cv2.circle(result, (u, v), max(1, image.shape[1] // 600), _DAMAGE, -1)
    return np.asarray(result)


def compared_picture(image: Image, compared: Any, sparse: bool) -> Image:
    """The image in grey, what was compared in colour; points of a scan are drawn larger.

    Args:
        image: Image of the reference camera.
        compared: Result of the comparison, see `comparison_map`.
        sparse: Whether one of the two maps is a scan's.
    """
    result = np.repeat(image.mean(axis=2, keepdims=True), 3, axis=2) * 0.6 + 80
    marks = {**_COLOURS, Comparison.FIRST_ONLY: _HOLE}
    if not sparse:
        marks[Comparison.SECOND_ONLY] = _HOLE
    for kind, colour in marks.items():
        mask = compared == kind
        if sparse:
            import cv2

            mask = cv2.dilate(mask.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
        result[mask] = 0.35 * result[mask] + 0.65 * np.array(colour)
    return result.clip(0, 255).astype(np.uint8)
