"""The look through KITTI's object layout, and through folders of labels and results."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.kitti.archives import ARCHIVES
from avsec_gym.kitti.calibration import read_calibration
from avsec_gym.kitti.dataset import file_suffix, layout_folders
from avsec_gym.kitti.label_folders import is_id
from avsec_gym.kitti.labels import read_detections, read_labels
from avsec_gym.kitti.layouts import KittiLayout, object_folders
from avsec_gym.kitti.report import FileCheck, Files, Sizes, Survey
from avsec_gym.kitti.sensor_files import check_scan_size, read_image, read_image_size, read_points
from avsec_gym.kitti.splits import read_raw_mapping, read_split
from avsec_gym.storage.regular_files import is_folder

_FETCH = "Are they exchanged? Fetch the file again."
_TOGETHER = (
    ("label_2", "calib"),
    ("label_2", "image_2"),
    ("image_2", "label_2"),
    ("image_2", "calib"),
    ("image_2", "image_3"),
    ("image_3", "image_2"),
    ("image_2", "velodyne"),
    ("velodyne", "calib"),
)


def check_object(survey: Survey, *, deep: bool) -> None:
    """Look at every file of the object benchmark, at its splits and its mapping to raw."""
    halves = object_folders(survey.root)
    folders = [half / name for half in halves for name in layout_folders(half)]
    frames = {folder: _frames(survey, folder, file_suffix(folder.name)) for folder in folders}
    survey.look_at([Files(f, paths, _look(f.name, deep)) for f, paths in frames.items()])
    ids = {folder: [path.name[:6] for path in paths] for folder, paths in frames.items()}
    for half in halves:
        _compare_folders(survey, half, ids)
    _check_lists(survey, ids)


def check_text_folder(survey: Survey, folder: Path) -> None:
    """Look at every file of a label folder, or of a detector's result folder."""
    look = _look_at_result if survey.layout is KittiLayout.DETECTIONS else _look_at_label
    survey.look_at([Files(folder, _frames(survey, folder, ".txt"), look)])


def look_at_image(deep: bool) -> FileCheck:
    """Looks at an image's header and end, or at all of it."""

    def look(path: Path, _: Counter[str], sizes: Sizes) -> None:
        sizes[path.stem] = read_image_size(path)
        if deep:
            read_image(path)

    return look


def look_at_scan(deep: bool) -> FileCheck:
    """Looks at a scan's size, or at all of it."""

    def look(path: Path, _: Counter[str], __: Sizes) -> None:
        check_scan_size(path)
        if deep:
            read_points(path)

    return look


def look_at_calibration(path: Path, _: Counter[str], __: Sizes) -> None:
    """Looks at a calibration file."""
    read_calibration(path)


def _look(folder: str, deep: bool) -> FileCheck:
    if folder == "velodyne":
        return look_at_scan(deep)
    looks: dict[str, FileCheck] = {"label_2": _look_at_label, "calib": _look_at_pair}
    return looks.get(folder) or look_at_image(deep)


def _look_at_pair(path: Path, _: Counter[str], __: Sizes) -> None:
    """Looks at a calibration file; where there are both images, its cameras 2 and 3 are a pair."""
    calibration, half = read_calibration(path), path.parent.parent
    if all(is_folder(half / f"image_{camera}") for camera in (2, 3)):
        try:
            baseline = calibration.baseline()
        except ConfigurationError as error:
            raise DataError(f"{error}.", path=path, remedy=_FETCH) from error
        if baseline <= 0:
            raise DataError(
                f"Camera 3 stands {-baseline:g} m to the left of camera 2.",
                path=path,
                remedy=_FETCH,
            )


def _look_at_label(path: Path, objects: Counter[str], _: Sizes) -> None:
    objects.update(read_labels(path, keep_dont_care=True).category.tolist())


def _look_at_result(path: Path, objects: Counter[str], _: Sizes) -> None:
    objects.update(read_detections(path).category.tolist())


def _frames(survey: Survey, folder: Path, suffix: str) -> list[Path]:
    """The folder's frames; what else lies there becomes a note."""
    previous = folder.name.startswith("prev_")
    frames: list[Path] = []
    others: list[Path] = []
    for path in sorted(folder.iterdir()):
        stem = path.name.removesuffix(suffix)
        frame = stem[:6] if previous and stem[6:] in ("_01", "_02", "_03") else stem
        fits = path.name.endswith(suffix) and is_id(frame)
        (frames if fits else others).append(path)
    survey.note_others(folder, others)
    if not frames:
        survey.notes.append(f"{survey.name(folder)} holds no frames.")
    return frames


def _compare_folders(survey: Survey, half: Path, ids: dict[Path, list[str]]) -> None:
    there = {folder.name: names for folder, names in ids.items() if folder.parent == half}
    label = f"{half.name}/" if half != survey.root else ""
    expected = ["calib", "label_2", "image_2", "image_3", "velodyne"]
    if half.name == "testing":
        expected.remove("label_2")
    missing = [name for name in expected if name not in there]
    survey.notes += [
        f"There is no folder {label}{name}; {ARCHIVES['object'][name]} brings it."
        for name in missing
    ]
    for has, lacks in _TOGETHER:
        if lacks in expected:
            survey.compare(label + has, there.get(has, ()), label + lacks, there.get(lacks, ()))
    survey.compare_sizes(half / "image_2", half / "image_3")


def _check_lists(survey: Survey, ids: dict[Path, list[str]]) -> None:
    for folder in _beside(ids, survey.root, "ImageSets"):
        for path in sorted(folder.glob("*.txt")):
            try:
                split = read_split(path)
            except DataError as error:
                survey.add(error)
                continue
            # The two halves of the benchmark count their frames alike.
            test = path.stem.startswith("test")
            here = {
                id
                for folder, there in ids.items()
                if (folder.parent.name == "testing") == test
                for id in there
            }
            found = sum(id in here for id in split)
            survey.notes.append(f"Split {path.stem}: {found} of {len(split)} frames are here.")
    for folder in _beside(ids, survey.root, "mapping"):
        try:
            survey.notes.append(f"The mapping to raw knows {len(read_raw_mapping(folder))}.")
        except DataError as error:
            survey.add(error)


def _beside(folders: Iterable[Path], root: Path, name: str) -> list[Path]:
    """Folders of that name in the root, in its halves, or beside them."""
    places = [root, *(folder.parent for folder in folders), root.absolute().parent]
    found = {(place / name).resolve(): place / name for place in places if is_folder(place / name)}
    return list(found.values())
