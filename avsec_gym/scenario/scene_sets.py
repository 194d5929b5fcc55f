"""Sets of scenes: the thesis' 600 labelled scenarios, any label folder, or procedural layouts."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.kitti.label_folders import frame_ids, other_names
from avsec_gym.kitti.labels import DONT_CARE, read_labels
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.commonroad_scenes import commonroad_folder
from avsec_gym.scenario.contested_sets import contested_sets
from avsec_gym.scenario.moving_flags import flagged
from avsec_gym.scenario.scene import Scene
from avsec_gym.scenario.scene_set import SceneSet, collected
from avsec_gym.storage.regular_files import is_file, is_folder
from avsec_gym.unknown_source import unknown_source
from avsec_gym.world.layouts import SceneLayout, generate_layouts

STATIC_STREET, DYNAMIC_STREET, DYNAMIC_HIGHWAY, WITHOUT_CARS = (
    "static street",
    "dynamic street",
    "dynamic highway",
    "without cars",
)
"""Groups of the labelled scenarios."""

LAYOUTS = "layouts"
"""Names the procedural ones."""
MIXED_CONTESTED, KITTI_CONTESTED = "mixed_contested", "kitti_contested"
"""Name those in which it matters what a car sees: procedural ones, and those of a user's labels."""

_PARTS = (
    ("static_label", None, STATIC_STREET, RoadType.STREET),
    ("dynamic_label", "dynamic_annotation", DYNAMIC_STREET, RoadType.STREET),
    ("road_dynamic_label", "road_dynamic_annotation", DYNAMIC_HIGHWAY, RoadType.HIGHWAY),
    ("nocar", None, WITHOUT_CARS, RoadType.STREET),
)


def labelled_scenarios(root: str | Path, *, seed: int = 0) -> SceneSet:
    """The labelled scenarios of the thesis' authors.

    Args:
        root: Folder with ``static_label``, ``dynamic_label`` and ``dynamic_annotation``,
            ``road_dynamic_label`` and ``road_dynamic_annotation``, ``nocar``; parts may be absent.
        seed: Seed of the speeds of moving objects.

    Raises:
        DataError: No part is there, or a file is broken.
    """
    root = Path(root)
    scenes: list[Scene] = []
    remarks: list[str] = []
    errors: list[DataError] = []
    for labels, notes, group, road_type in _PARTS:
        folder = root / labels
        if not is_folder(folder):
            continue
        remarks += _unread(folder)
        for id in frame_ids(folder, ".txt"):
            flags = root / notes / f"{id}.txt" if notes else None
            try:
                scene, remark = labelled_scene(folder / f"{id}.txt", flags, road_type, seed, group)
            except DataError as error:
                errors.append(error)
            else:
                scenes.append(scene)
                remarks += remark
    if not scenes and not errors:
        raise DataError(
            "none of the labelled scenarios' folders is here.",
            path=root,
            remedy=f"Expected one of {', '.join(part[0] for part in _PARTS)}.",
        )
    return collected(root.name, sorted(scenes, key=lambda scene: scene.id), remarks, errors)


def label_folder(
    folder: str | Path,
    *,
    flags: str | Path | None = None,
    ids: Sequence[str] | None = None,
    road_type: RoadType = RoadType.STREET,
    seed: int = 0,
) -> SceneSet:
    """Scenes of any folder of KITTI label files; everything stands unless flags state otherwise.

    Args:
        folder: The folder, which holds ``000123.txt`` files.
        flags: Folder with files of the same names: a line for each label line from the top, ``n``
            (no obstacle), ``0`` (stands), ``1`` or ``-1`` (moves).
        ids: Ids of the frames; None: all.
        road_type: Road type of every frame.
        seed: Seed of the speeds of moving objects.

    Raises:
        DataError: A file is missing or broken, or the folder holds no label file.
    """
    if not is_folder(folder):
        raise DataError("There is no such folder.", path=folder, remedy="Check the path.")
    folder = Path(folder)
    scenes: list[Scene] = []
    remarks = _unread(folder) if ids is None else []
    errors: list[DataError] = []
    for id in frame_ids(folder, ".txt") if ids is None else ids:
        own = None if flags is None else Path(flags) / f"{id}.txt"
        try:
            scene, remark = labelled_scene(
                folder / f"{id}.txt",
                own if own is not None and is_file(own) else None,
                road_type,
                seed,
                str(road_type),
            )
        except DataError as error:
            errors.append(error)
        else:
            scenes.append(scene)
            remarks += remark
    if not scenes and not errors and ids is None:
        raise DataError(
            "the folder holds no label file.",
            path=folder,
            remedy="Label files are named by their frame, such as 000107.txt.",
        )
    return collected(folder.name, scenes, remarks, errors)


def procedural_scenes(count: int = 200, *, seed: int = 0) -> SceneSet:
    """The embedded default: seeded KITTI-like layouts, streets and highways."""
    scenes = tuple(scene_of_layout(layout, seed) for layout in generate_layouts(count, seed))
    return SceneSet(f"layouts-{seed}", scenes)


def scene_of_layout(layout: SceneLayout, seed: int = 0) -> Scene:
    """The scene that a procedural layout is.

    Args:
        layout: The layout.
        seed: Seed of the speeds of moving objects.
    """
    return Scene(
        layout.id,
        layout.boxes,
        layout.road_type,
        seed=seed,
        number=layout.index,
        group=str(layout.road_type),
    )


def scene_set(
    name: str | Path,
    *,
    kitti: str | Path | None = None,
    seed: int = 0,
    count: int | None = None,
    contested: bool = False,
) -> SceneSet:
    """The set that a name or a folder stands for.

    Args:
        name: ``layouts``; ``mixed_contested``, contested layouts; a folder of the labelled
            scenarios; a folder of label files (with flags in a folder ``flags`` inside or beside
            it), or of KITTI's object data; ``kitti_contested``, the contested ones of the folder
            `kitti`; a folder of CommonRoad files; or a text file with one frame id a line, of the
            KITTI root.
        kitti: Root of the KITTI object data, for a list of ids; any folder of labels, for
            ``kitti_contested``.
        seed: Seed of speeds and layouts.
        count: Number of scenes; None: all (200 layouts, 100 contested ones).
        contested: Whether only contested scenes are taken; see `avsec_gym.evaluation.contested`.

    Raises:
        ConfigurationError: The name is mistyped, or a list of ids lacks its KITTI root.
        DataError: A folder or file is missing or broken.
    """
    path = Path(name)
    if str(name) == MIXED_CONTESTED or (contested and str(name) == LAYOUTS):
        return contested_sets().contested_layouts(count, seed=seed)
    if contested or str(name) == KITTI_CONTESTED:
        if not contested and kitti is None:
            raise ConfigurationError(
                f"{KITTI_CONTESTED} are the contested ones of the labels in a folder: name it with "
                "--kitti, or as kitti, such as the folder of the labelled scenarios"
            )
        folder = name if contested or kitti is None else kitti
        return contested_sets().contested(scene_set(folder, seed=seed)).limited(count)
    if str(name) == LAYOUTS:
        return procedural_scenes(200 if count is None else count, seed=seed)
    if is_file(path) and kitti is not None:
        from avsec_gym.kitti import KittiObject, read_split

        ids = read_split(path)[:count]
        return kitti_scenes(KittiObject(kitti), ids, seed=seed)
    if not is_folder(path):
        if is_file(path):
            raise ConfigurationError(
                f"{path} is a file: a list of frame ids stands beside --kitti ROOT"
            )
        raise unknown_source(
            str(name),
            [LAYOUTS, MIXED_CONTESTED, KITTI_CONTESTED],
            "Name a folder of labels or of CommonRoad files, a list of frame ids beside --kitti, "
            f"{LAYOUTS!r}, {MIXED_CONTESTED!r} or {KITTI_CONTESTED!r}.",
        )
    return _of_folder(path, seed).limited(count)


def _of_folder(folder: Path, seed: int) -> SceneSet:
    """The labelled scenarios, the CommonRoad files or else the label files of a folder."""
    if any(is_folder(folder / part[0]) for part in _PARTS):
        return labelled_scenarios(folder, seed=seed)
    if any(folder.glob("*.xml")):
        return commonroad_folder(folder)
    inside = ("label_2", "labels", "training/label_2")
    labels = next((folder / sub for sub in inside if is_folder(folder / sub)), folder)
    beside = (folder / "flags", folder.parent / "flags")
    flags = next((place for place in beside if is_folder(place) and place != labels), None)
    return label_folder(labels, flags=flags, seed=seed)


def kitti_scenes(data: object, ids: Sequence[str], *, seed: int = 0) -> SceneSet:
    """Frames of the KITTI object data, every object standing.

    Args:
        data: A `KittiObject`.
        ids: Ids of the frames.
        seed: A seed that is kept with the scenes.
    """
    scenes: list[Scene] = []
    errors: list[DataError] = []
    for id in ids:
        try:
            boxes = data.labels(id)  # type: ignore[attr-defined]
            scenes.append(_scene(id, boxes, RoadType.STREET, seed, str(RoadType.STREET)))
        except DataError as error:
            errors.append(error)
    return collected("kitti", scenes, [], errors)


def labelled_scene(
    labels: Path, flags: Path | None, road_type: RoadType, seed: int, group: str
) -> tuple[Scene, list[str]]:
    """One scene of a label file, and the remarks about it.

    Args:
        labels: The label file.
        flags: File of the moving flags; None: everything stands.
        road_type: Road type of the scene.
        seed: Seed of the speeds of moving objects.
        group: A subset that the scene belongs to.

    Raises:
        DataError: A file is missing or broken.
    """
    boxes, remark = read_labels(labels, keep_dont_care=True), None
    if flags is not None:
        boxes, remark = flagged(boxes, flags)
    scene = _scene(labels.stem, boxes, road_type, seed, group)
    return scene, [remark] if remark else []


def _unread(folder: Path) -> list[str]:
    """A remark on files that are not named as frames are."""
    names = other_names(folder, ".txt")
    if not names:
        return []
    return [
        f"{len(names)} files of {folder.name} are not named by a frame of six digits and were not"
        f" read, such as {names[0]}"
    ]


def _scene(id: str, boxes: Boxes3D, road_type: RoadType, seed: int, group: str) -> Scene:
    if boxes.moving is None:
        boxes = replace(boxes, moving=np.zeros(len(boxes), bool))
    boxes = boxes[boxes.category != DONT_CARE]
    digits = re.sub(r"\D", "", id)
    return Scene(id, boxes, road_type, seed, int(digits or 0), group)
