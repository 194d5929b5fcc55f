"""The files of one frame: KITTI's own, and beside them the truth that KITTI lacks.

In the object layout a frame's truth lies in folders beside ``label_2``, in a raw drive in folders
such as ``disparity_02/data``:

==============  ==================================================================================
``disparity``   16-bit PNG, KITTI's stereo format: of every pixel but the sky
``surface``     8-bit PNG: `avsec_gym.world.section.Surface`
``instance``    16-bit PNG: number of the label line, counted from 1; 0 for all else
``moving``      a flag a label line: ``n`` no obstacle, ``0`` stands, ``1`` moves, ``-1`` comes
                towards the ego vehicle
``scene``       JSON: road type, light, who the labelled objects are and how fast
==============  ==================================================================================
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.map_files import write_disparity, write_mask
from avsec_gym.kitti.writing import write_object_frame
from avsec_gym.storage.text_files import write_text
from avsec_gym.world.capture import Capture
from avsec_gym.world.labels import dont_care_boxes
from avsec_gym.world.posed_scenes import PosedScene

TruthPlace = Callable[[str, str], Path]
"""A function from a kind of truth, such as ``disparity``, and a suffix to a frame's file."""

OBSTACLES = ("Car", "Van", "Truck", "Misc")
"""What gets a moving flag; the rest is no obstacle (as in the labelled scenarios)."""

_LARGEST_DISPARITY = 255.99
_MAPS = ("disparity", "surface", "instance")


def write_object_files(
    folder: Path,
    id: str,
    posed: PosedScene,
    capture: Capture,
    *,
    previous: tuple[Capture, ...] = (),
    notes: Mapping[str, Any] | None = None,
) -> None:
    """Write a frame in the object layout, over what is there of it; the label file last.

    Args:
        folder: The object layout's folder, such as ``training``.
        id: The frame's id, six digits.
        posed: The scene that was rendered.
        capture: The sensors' measurements and the truth.
        previous: Measurements of the frames before it, the latest first.
        notes: Further entries of the scene file.
    """

    def place(kind: str, suffix: str) -> Path:
        return folder / (f"{kind}_2" if kind in _MAPS else kind) / f"{id}{suffix}"

    labels = label_lines(capture)
    write_truth(place, labels, posed, capture, notes or {})
    calibration = posed.rig.calibration
    earlier_frames = tuple(
        SensorFrame(f"{id}_{step:02d}", calibration, earlier.images)
        for step, earlier in enumerate(previous, start=1)
    )
    scan = None if capture.scan is None else capture.scan.points
    frame = SensorFrame(id, calibration, capture.images, scan, earlier_frames)
    write_object_frame(folder, frame, labels, overwrite=True)


def write_truth(
    place: TruthPlace,
    labels: Boxes3D,
    posed: PosedScene,
    capture: Capture,
    notes: Mapping[str, Any],
) -> None:
    """Write what KITTI lacks; see the module.

    Args:
        place: Paths of the files.
        labels: The frame's `label_lines`.
        posed: The scene that was rendered.
        capture: The sensors' measurements and the truth.
        notes: Further entries of the scene file.
    """
    disparity = capture.disparity
    # The format has no number for what is nearer than one and a half metres.
    told = np.where(disparity <= _LARGEST_DISPARITY, disparity, np.nan).astype(np.float32)
    write_disparity(place("disparity", ".png"), told, overwrite=True)
    write_mask(place("surface", ".png"), capture.geometry.surface, overwrite=True)
    write_mask(place("instance", ".png"), line_numbers(capture), overwrite=True)
    flags = "".join(f"{flag}\n" for flag in moving_flags(labels))
    write_text(place("moving", ".txt"), flags, overwrite=True)
    text = json.dumps(_scene(posed, capture) | dict(notes), indent=1, allow_nan=False)
    write_text(place("scene", ".json"), text + "\n", overwrite=True)


def label_lines(capture: Capture) -> Boxes3D:
    """The lines of the label file: the objects, then regions not to care about.

    Tenths of a millimetre, hundredths of a pixel: sharper than KITTI's, shorter than the truth.
    """
    seen, regions = capture.labels.boxes, dont_care_boxes(capture.labels.dont_care)
    regions = replace(regions, moving=np.zeros(len(regions), bool))
    boxes = Boxes3D.concatenate([seen, regions])
    digits = {"location": 4, "dimensions": 4, "rotation_y": 4, "alpha": 4}
    digits |= {"box2d": 2, "truncation": 2}
    rounded = {name: np.round(getattr(boxes, name), digits[name]) for name in digits}
    return replace(boxes, **rounded)


def line_numbers(capture: Capture) -> np.ndarray:
    """Number of the label line that each pixel belongs to, counted from 1, shape (H, W)."""
    actor, ids = capture.labels.actor, capture.geometry.object_id
    # The last entry is for pixels without an object, whose id is -1.
    lines = np.zeros(max(int(ids.max()), int(actor.max(initial=-1))) + 2, np.uint16)
    lines[actor] = np.arange(1, len(actor) + 1)
    return np.asarray(lines[ids])


def moving_flags(labels: Boxes3D) -> list[str]:
    """A flag for each label line, as `avsec_gym.scenario.moving_flags` reads them."""
    moving = np.zeros(len(labels), bool) if labels.moving is None else labels.moving
    oncoming = np.cos(labels.poses[:, 2]) < 0
    return [
        "n" if category not in OBSTACLES else "0" if not moves else "-1" if comes else "1"
        for category, moves, comes in zip(labels.category, moving, oncoming, strict=True)
    ]


def _scene(posed: PosedScene, capture: Capture) -> dict[str, Any]:
    light, actors, seen = posed.built.light, posed.instant.actors, capture.labels.actor
    return {
        "road_type": str(posed.site.road_type),
        "style": str(posed.site.style),
        "sun_azimuth": round(float(light.azimuth), 4),
        "sun_elevation": round(float(light.elevation), 4),
        "cloudiness": float(light.cloudiness),
        "haze": round(float(light.haze), 1),
        "objects": [
            {
                "category": str(actors.category[index]),
                "actor": int(actors.id[index]),
                "speed": round(float(actors.speed[index]), 3),
                "moving": bool(actors.moving[index]),
            }
            for index in seen
        ],
    }
