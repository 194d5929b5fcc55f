"""A picture of an alarm: what the sensors saw, and where they contradict each other."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from avsec_gym.frame import Image
from avsec_gym.kitti.atomic_write import write_bytes
from avsec_gym.report.frame_picture import points_in_image
from avsec_gym.sensor_system import LIDAR, Sensor, Triple
from avsec_gym.validation.comparison import Comparison, comparison_map
from avsec_gym.validation.state_posterior import Verdict
from avsec_gym.validation.validator import Validation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = {Comparison.INCONSISTENT: (215, 38, 61), Comparison.CONSISTENT: (60, 160, 110)}
_HOLE = (70, 110, 220)
_LEGEND = "right: red inconsistent, green consistent, blue unknown to one of the two"
_MARKS = {Verdict.ATTACKED: "#D7263D", Verdict.CANNOT_TELL: "#B8860B", Verdict.SOUND: "#222222"}


def draw_validation(
    validation: Validation, thresholds: Mapping[Triple, float] | None = None
) -> Figure:
    """Left: the sensors with their verdicts.  Right: the triples of the reference.

    Red: inconsistent pixels; green: consistent ones; blue: holes that one of two maps has.

    Args:
        validation: Of one moment.
        thresholds: For E, named beside it where they are given.
    """
    from matplotlib.figure import Figure

    maps = validation.errors.maps
    system, frame = maps.system, maps.frame
    known = validation.errors.known
    last = max((k for _, _, k in known), default=len(system) - 1)
    triples = [triple for triple in known if triple[2] == last]
    rows = max(len(system), len(triples))
    figure = Figure(
        figsize=(12, 0.3 + 2.15 * rows), dpi=100, facecolor="white", layout="constrained"
    )
    figure.suptitle(_LEGEND, fontsize=9, x=0.99, ha="right")
    panels = figure.subplots(rows, 2, squeeze=False)
    for axes in panels.flat:
        axes.set_axis_off()
    for axes, sensor in zip(panels[:, 0], system.sensors, strict=False):
        said = validation.verdicts[sensor]
        title = f"{named(sensor)}: {said}"
        if validation.probabilities is not None:
            title += f", P(attacked) = {validation.probabilities[sensor]:.3f}"
        reference = frame.image(system.reference)
        scan = points_in_image(reference, frame, system.reference) if sensor == LIDAR else None
        axes.imshow(frame.image(int(sensor)) if scan is None else scan)
        axes.set_title(title, loc="left", fontsize=9, color=_MARKS[said])
    for axes, (i, j, k) in zip(panels[:, 1], triples, strict=False):
        error = validation.errors[i, j, k]
        who = (named(system.sensors[one]) for one in (i, j, k))
        text = "{} against {}, seen by {}\n".format(*who) + f"E = {error.error:.3f}"
        if thresholds is not None:
            text += f" (threshold {thresholds[i, j, k]:.3f})"
        compared = comparison_map(maps[i, k], maps[j, k])
        sparse = system.sensors[i] == LIDAR
        axes.imshow(_overlaid(frame.image(int(system.sensors[k])), compared, sparse))
        text += f", holes {error.hole_share:.2f}, densest {error.densest:.3f}"
        text += f", other brightness {error.brightness:.3f}"
        axes.set_title(text, loc="left", fontsize=9)
    return figure


def save_validation_picture(
    validation: Validation, path: Path, thresholds: Mapping[Triple, float] | None = None
) -> None:
    """Write it as PNG, over one that is there; see `draw_validation`."""
    import io

    content = io.BytesIO()
    draw_validation(validation, thresholds).savefig(content, format="png")
    write_bytes(path, content.getvalue(), overwrite=True)


def named(sensor: Sensor) -> str:
    """For people: ``LiDAR``, ``camera 3``."""
    return "LiDAR" if sensor == LIDAR else f"camera {sensor}"


def _overlaid(image: Image, compared: Any, sparse: bool) -> Image:
    """The image in grey, what was compared in colour; points of a scan are drawn larger."""
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
