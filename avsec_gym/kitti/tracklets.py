"""Tracked objects of a KITTI raw drive: ``tracklet_labels.xml``, an archive of Boost's.

Facts of the raw devkit: a tracklet has one size and a pose for each frame from its first one on;
the translation is the centre of the bottom in the velodyne frame, rz the yaw about its z axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import Calibration
from avsec_gym.geometry import Floats, Integers, transform_points
from avsec_gym.kitti.label_ranges import LARGEST_LABEL
from avsec_gym.storage.text_files import write_text
from avsec_gym.storage.xml_tree import Element, read_xml

INTERPOLATED, LABELLED = 1, 2
"""Values of `Tracklet.state`; 0 is unset."""
IN_IMAGE, TRUNCATED, OUT_OF_IMAGE, BEHIND_IMAGE = 0, 1, 2, 99
"""Values of `Tracklet.truncation`; -1 is unset."""


_POSE = ("tx", "ty", "tz", "rx", "ry", "rz")
_LEVELS = ("state", "occlusion", "truncation")
_NOTES = (
    "occlusion_kf",
    "amt_occlusion",
    "amt_occlusion_kf",
    "amt_border_l",
    "amt_border_r",
    "amt_border_kf",
)
_SHARES = {IN_IMAGE: 0.0, OUT_OF_IMAGE: 1.0, BEHIND_IMAGE: 1.0}


@dataclass(frozen=True, eq=False)
class Tracklet:
    """One object over T frames without a gap.

    Args:
        category: KITTI's category, such as ``Car``.
        dimensions: Height, width, length, shape (3,), metres.
        first_frame: The number of its first frame.
        translation: Bottom centres in the velodyne frame, shape (T, 3), metres.
        rotation: Angles rx, ry, rz in the velodyne frame, shape (T, 3); KITTI's rx and ry are zero.
        state: `INTERPOLATED` or `LABELLED`, shape (T,).
        occlusion: Levels of occlusion: 0 visible, 1 partly, 2 fully, -1 unset, shape (T,).
        truncation: `IN_IMAGE` and so on, for camera 2, shape (T,).
        notes: Fields that KITTI's labelling tool kept for itself, shape (T, 6): occlusion_kf,
            amt_occlusion, amt_occlusion_kf, amt_border_l, amt_border_r, amt_border_kf.
        finished: Whether its labelling was finished.

    Raises:
        ConfigurationError: A shape does not fit, a value is not finite, a size not positive or
            beyond `LARGEST_LABEL`, the first frame negative, or the category not a plain word.
    """

    category: str
    dimensions: Floats
    first_frame: int
    translation: Floats
    rotation: Floats
    state: Integers
    occlusion: Integers
    truncation: Integers
    notes: Floats | None = None
    finished: bool = True

    def __post_init__(self) -> None:
        count = len(self.translation)
        if self.notes is None:
            object.__setattr__(self, "notes", np.full((count, len(_NOTES)), -1.0))
        shapes: dict[str, tuple[int, ...]] = {
            "dimensions": (3,),
            "translation": (count, 3),
            "rotation": (count, 3),
            "notes": (count, len(_NOTES)),
            **dict.fromkeys(_LEVELS, (count,)),
        }
        for name, shape in shapes.items():
            values = np.asarray(getattr(self, name), np.int64 if name in _LEVELS else np.float64)
            if values.shape != shape or not np.isfinite(values).all():
                raise ConfigurationError(
                    f"Tracklet.{name} is finite and has shape {shape}, got shape {values.shape}"
                )
            object.__setattr__(self, name, values)
        sized = ((self.dimensions > 0) & (self.dimensions <= LARGEST_LABEL)).all()
        if not (count and sized and self.first_frame >= 0):
            raise ConfigurationError(
                "a tracklet has poses, a height, width and length above 0 and up to"
                f" {LARGEST_LABEL.tolist()} m, and a first frame of 0 or more; got {count} poses,"
                f" {self.dimensions.tolist()} m, first frame {self.first_frame}"
            )
        if not self.category.isidentifier():
            raise ConfigurationError(f"a category is a plain word, got {self.category!r}")

    @property
    def frames(self) -> range:
        """The numbers of its frames."""
        return range(self.first_frame, self.first_frame + len(self.translation))


def tracklet_boxes(tracklets: Sequence[Tracklet], frame: int, calibration: Calibration) -> Boxes3D:
    """The objects of a frame, in the order of the tracklets that have it.

    Returns:
        Boxes in the rectified camera frame.  Of a truncated object the share outside is unknown,
        -1; 2D boxes and observation angles are not in the files.
    """
    there = [tracklet for tracklet in tracklets if frame in tracklet.frames]
    if not there:
        return Boxes3D.empty()
    rows = [frame - tracklet.first_frame for tracklet in there]
    pairs = list(zip(there, rows, strict=True))
    yaw = np.array([tracklet.rotation[row, 2] for tracklet, row in pairs])
    transform = calibration.velodyne_to_camera
    forward = np.stack([np.cos(yaw), np.sin(yaw), np.zeros(len(yaw))], axis=1)
    heading = forward @ transform[:3, :3].T
    return Boxes3D(
        location=transform_points(transform, [t.translation[row] for t, row in pairs]),
        dimensions=np.array([tracklet.dimensions for tracklet in there]),
        rotation_y=np.arctan2(-heading[:, 2], heading[:, 0]),
        score=np.ones(len(there)),
        category=np.array([tracklet.category for tracklet in there]),
        truncation=np.array([_SHARES.get(int(t.truncation[row]), -1.0) for t, row in pairs]),
        occlusion=np.array([float(t.occlusion[row]) for t, row in pairs]),
    )


def read_tracklets(path: str | Path) -> tuple[Tracklet, ...]:
    """All tracklets of a drive, in the file's order.

    Args:
        path: A ``tracklet_labels.xml``.

    Raises:
        DataError: Missing, too large, cut off, no such XML, a count or a number that does not fit.
    """
    root = read_xml(path)
    if root.name != "boost_serialization":
        root.refuse(f"A tracklet file begins with <boost_serialization>, this one <{root.name}>.")
    return tuple(_tracklet(item) for item in _items(root.child("tracklets")))


def write_tracklets(
    path: str | Path, tracklets: Sequence[Tracklet], *, overwrite: bool = False
) -> None:
    """Write ``tracklet_labels.xml``, lossless; KITTI's own come out byte for byte.

    Raises:
        DataError: The file exists and `overwrite` is false, or cannot be written.
    """
    ids = {"tracklets": (0, 0), "item": (1, 1), "poses": (2, 0), "pose": (3, 2)}

    def attributes(kind: str) -> str:
        """Boost writes them where a class stands first."""
        if kind not in ids:
            return ""
        number, version = ids.pop(kind)
        return f' class_id="{number}" tracking_level="0" version="{version}"'

    lines = [
        '<?xml version="1.0" encoding="UTF-8" standalone="yes" ?>',
        "<!DOCTYPE boost_serialization>",
        '<boost_serialization signature="serialization::archive" version="9">',
        f"<tracklets{attributes('tracklets')}>",
        f"\t<count>{len(tracklets)}</count>",
        "\t<item_version>1</item_version>",
    ]
    for tracklet in tracklets:
        height, width, length = tracklet.dimensions.tolist()
        lines += [
            f"\t<item{attributes('item')}>",
            f"\t\t<objectType>{tracklet.category}</objectType>",
            f"\t\t<h>{_word(height)}</h>",
            f"\t\t<w>{_word(width)}</w>",
            f"\t\t<l>{_word(length)}</l>",
            f"\t\t<first_frame>{tracklet.first_frame}</first_frame>",
            f"\t\t<poses{attributes('poses')}>",
            f"\t\t\t<count>{len(tracklet.frames)}</count>",
            "\t\t\t<item_version>2</item_version>",
        ]
        for row in _pose_rows(tracklet):
            lines.append(f"\t\t\t<item{attributes('pose')}>")
            lines += [f"\t\t\t\t<{name}>{_word(value)}</{name}>" for name, value in row.items()]
            lines.append("\t\t\t</item>")
        finished = int(tracklet.finished)
        lines += ["\t\t</poses>", f"\t\t<finished>{finished}</finished>", "\t</item>"]
    lines += ["</tracklets>", "</boost_serialization>", "", ""]
    write_text(path, "\n".join(lines), overwrite=overwrite)


def _items(parent: Element) -> list[Element]:
    items, count = parent.all("item"), parent.child("count")
    if count.text != str(len(items)):
        count.refuse(f"<{parent.name}> promises {count.text[:40]} items and has {len(items)}.")
    return items


def _tracklet(item: Element) -> Tracklet:
    first = item.number("first_frame")
    if first != int(first):
        item.child("first_frame").refuse(f"The first frame is {first}, no whole number.")
    poses = _items(item.child("poses"))
    values = [[pose.number(name) for name in _POSE] for pose in poses]
    levels = [[pose.number(name) for name in _LEVELS] for pose in poses]
    notes = [[pose.number(name, default=-1.0) for name in _NOTES] for pose in poses]
    table = np.array(values, np.float64).reshape(len(poses), len(_POSE))
    states = np.array(levels, np.int64).reshape(len(poses), len(_LEVELS))
    try:
        return Tracklet(
            category=item.child("objectType").text,
            dimensions=np.array([item.number(name) for name in "hwl"]),
            first_frame=int(first),
            translation=table[:, :3],
            rotation=table[:, 3:],
            state=states[:, 0],
            occlusion=states[:, 1],
            truncation=states[:, 2],
            notes=np.array(notes, np.float64).reshape(len(poses), len(_NOTES)),
            finished=bool(item.number("finished", default=1.0)),
        )
    except ConfigurationError as error:
        item.refuse(f"This cannot be a tracklet: {error}.")


def _pose_rows(tracklet: Tracklet) -> list[dict[str, float]]:
    """The values of each pose in the file's order."""
    assert tracklet.notes is not None, "__post_init__ fills them"
    columns = {
        **dict(zip(_POSE, (*tracklet.translation.T, *tracklet.rotation.T), strict=True)),
        "state": tracklet.state,
        "occlusion": tracklet.occlusion,
        _NOTES[0]: tracklet.notes[:, 0],
        "truncation": tracklet.truncation,
        **dict(zip(_NOTES[1:], tracklet.notes[:, 1:].T, strict=True)),
    }
    rows = np.stack(list(columns.values()), axis=1).tolist()
    return [dict(zip(columns, row, strict=True)) for row in rows]


def _word(value: float) -> str:
    """The 17 digits of Boost, but a number that fewer digits hold exactly stays short."""
    short = f"{value:.8g}"
    return short if float(short) == value else f"{value:.17g}"
