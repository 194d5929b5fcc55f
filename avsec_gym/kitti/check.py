"""What is there, what is missing and what is broken in a folder of KITTI data."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from avsec_gym.errors import DataError
from avsec_gym.kitti.calibration import read_calibration
from avsec_gym.kitti.dataset import file_suffix, layout_folders
from avsec_gym.kitti.label_folders import is_id
from avsec_gym.kitti.labels import read_detections, read_labels
from avsec_gym.kitti.layouts import Layout, object_folders, recognise, text_file_folder
from avsec_gym.kitti.sensor_files import check_scan_size, read_image, read_image_size, read_points
from avsec_gym.kitti.splits import read_raw_mapping, read_split

Progress = Callable[[int, int], None]
"""Called with the files done and the files in all."""


@dataclass(frozen=True)
class Part:
    """One folder of the layout."""

    folder: str
    files: int
    broken: int
    objects: dict[str, int]
    """Labelled or detected objects by category, where the files hold such."""
    image_sizes: dict[str, int]
    """Images by size, such as ``1242x375``."""


@dataclass(frozen=True)
class Gap:
    """Frames that have one thing and lack another."""

    has: str
    lacks: str
    frames: int
    examples: tuple[str, ...]

    def __str__(self) -> str:
        return (
            f"{self.frames} frames have {self.has} but no {self.lacks}, "
            f"such as {', '.join(self.examples)}"
        )


@dataclass(frozen=True)
class BrokenFile:
    """A file that cannot be used, and why."""

    path: str | None
    line: int | None
    problem: str
    remedy: str

    def __str__(self) -> str:
        return str(DataError(self.problem, path=self.path, line=self.line, remedy=self.remedy))


@dataclass(frozen=True)
class DataReport:
    """What `check_object_root` found."""

    root: str
    layout: Layout
    parts: tuple[Part, ...] = ()
    gaps: tuple[Gap, ...] = ()
    broken: tuple[BrokenFile, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether there is usable data and none of it is broken; gaps are no fault."""
        return not self.broken and any(part.files for part in self.parts)

    def to_json(self) -> dict[str, Any]:
        """Everything as `json.dumps` takes it."""
        return {**asdict(self), "layout": str(self.layout), "ok": self.ok}


def check_object_root(
    root: str | Path, *, deep: bool = False, on_progress: Progress | None = None
) -> DataReport:
    """Look at every file of the object layout or of a detector's result folder.

    Goes on after a broken file.  Folders of other layouts are recognised, not checked.

    Args:
        root: The folder that holds ``training/``, one such as ``training``, or results.
        deep: Read images and scans whole; else headers, ends and sizes.
        on_progress: Called after each file.

    Raises:
        DataError: There is no such folder.
    """
    root = Path(root)
    layout = recognise(root)
    if layout is Layout.OBJECT:
        folders = [half / name for half in object_folders(root) for name in layout_folders(half)]
    else:
        folder = text_file_folder(root)
        folders = [] if folder is None else [folder]
    survey = _Survey(root, layout, deep, on_progress)
    survey.walk(folders)
    if layout is Layout.OBJECT:
        survey.compare_folders()
        survey.check_lists()
    elif layout is Layout.UNKNOWN:
        survey.notes += [
            f"Its subfolder {child.name}/ has the object layout: name that."
            for child in sorted(root.iterdir())
            if child.is_dir() and recognise(child) is Layout.OBJECT
        ]
    return survey.report()


class _Survey:
    """Collects what is found on the way."""

    def __init__(
        self, root: Path, layout: Layout, deep: bool, on_progress: Progress | None
    ) -> None:
        self.root, self.layout, self.deep, self.on_progress = root, layout, deep, on_progress
        self.parts: list[Part] = []
        self.gaps: list[Gap] = []
        self.broken: list[BrokenFile] = []
        self.notes: list[str] = [layout.description]
        self.ids: dict[Path, list[str]] = {}
        self.sizes: dict[Path, dict[str, tuple[int, int]]] = {}

    def walk(self, folders: list[Path]) -> None:
        files = {folder: self._files(folder) for folder in folders}
        total, done = sum(map(len, files.values())), 0
        for folder, paths in files.items():
            before = len(self.broken)
            objects: Counter[str] = Counter()
            sizes: dict[str, tuple[int, int]] = {}
            for path in paths:
                try:
                    self._check_file(path, objects, sizes)
                except DataError as error:
                    self._add(error)
                done += 1
                if self.on_progress is not None:
                    self.on_progress(done, total)
            self.sizes[folder] = sizes
            images = Counter(f"{width}x{height}" for width, height in sizes.values())
            self.parts.append(
                Part(
                    self._name(folder),
                    len(paths),
                    len(self.broken) - before,
                    dict(objects),
                    dict(images),
                )
            )

    def compare_folders(self) -> None:
        for half in dict.fromkeys(folder.parent for folder in self.ids):
            there = {f.name: set(ids) for f, ids in self.ids.items() if f.parent == half}
            label = f"{half.name}/" if half != self.root else ""
            expected = ["calib", "label_2", "image_2", "image_3", "velodyne"]
            if half.name == "testing":
                expected.remove("label_2")
            for name in expected:
                if name not in there:
                    self.notes.append(f"There is no folder {label}{name}.")
            for has, lacks in _EXPECTED_TOGETHER:
                lacking = sorted(there.get(has, set()) - there.get(lacks, set()))
                if lacking and lacks in expected:
                    self.gaps.append(
                        Gap(label + has, label + lacks, len(lacking), tuple(lacking[:3]))
                    )
            left, right = (self.sizes.get(half / name, {}) for name in ("image_2", "image_3"))
            for id in sorted(left.keys() & right.keys()):
                if left[id] != right[id]:
                    problem = f"The right image has {right[id]} pixels, the left one {left[id]}."
                    path = half / "image_3" / f"{id}.png"
                    self._add(DataError(problem, path=path, remedy="Fetch both again."))

    def check_lists(self) -> None:
        for folder in _beside(self.ids, self.root, "ImageSets"):
            for path in sorted(folder.glob("*.txt")):
                try:
                    ids = read_split(path)
                except DataError as error:
                    self._add(error)
                else:
                    # The two halves of the benchmark count their frames alike.
                    test = path.stem.startswith("test")
                    here = {
                        id
                        for folder, there in self.ids.items()
                        if (folder.parent.name == "testing") == test
                        for id in there
                    }
                    found = sum(id in here for id in ids)
                    self.notes.append(f"Split {path.stem}: {found} of {len(ids)} frames are here.")
        for folder in _beside(self.ids, self.root, "mapping"):
            try:
                self.notes.append(f"The mapping to raw knows {len(read_raw_mapping(folder))}.")
            except DataError as error:
                self._add(error)

    def report(self) -> DataReport:
        gaps, broken, notes = tuple(self.gaps), tuple(self.broken), tuple(self.notes)
        return DataReport(str(self.root), self.layout, tuple(self.parts), gaps, broken, notes)

    def _files(self, folder: Path) -> list[Path]:
        """The folder's frames; what else lies there becomes a note."""
        suffix = file_suffix(folder.name) if self.layout is Layout.OBJECT else ".txt"
        previous = folder.name.startswith("prev_")
        frames: list[Path] = []
        others: list[Path] = []
        for path in sorted(folder.iterdir()):
            stem = path.name.removesuffix(suffix)
            frame = stem[:6] if previous and stem[6:] in ("_01", "_02", "_03") else stem
            fits = path.name.endswith(suffix) and is_id(frame)
            (frames if fits else others).append(path)
        if others:
            self.notes.append(
                f"{self._name(folder)} holds {len(others)} entries that are no frames, "
                f"such as {others[0].name!r}."
            )
        if not frames:
            self.notes.append(f"{self._name(folder)} holds no frames.")
        self.ids[folder] = [path.name[:6] for path in frames]
        return frames

    def _check_file(
        self, path: Path, objects: Counter[str], sizes: dict[str, tuple[int, int]]
    ) -> None:
        kind = path.parent.name
        if self.layout is Layout.DETECTIONS:
            objects.update(read_detections(path).category.tolist())
        elif kind == "label_2" or self.layout is not Layout.OBJECT:
            objects.update(read_labels(path, keep_dont_care=True).category.tolist())
        elif kind == "calib":
            read_calibration(path)
        elif kind == "velodyne":
            _ = read_points(path) if self.deep else check_scan_size(path)
        else:
            sizes[path.stem] = read_image_size(path)
            if self.deep:
                read_image(path)

    def _add(self, error: DataError) -> None:
        self.broken.append(BrokenFile(error.path, error.line, error.problem, error.remedy))

    def _name(self, folder: Path) -> str:
        return str(folder.relative_to(self.root)) if folder != self.root else folder.name


_EXPECTED_TOGETHER = (
    ("label_2", "calib"),
    ("label_2", "image_2"),
    ("image_2", "label_2"),
    ("image_2", "calib"),
    ("image_2", "image_3"),
    ("image_3", "image_2"),
    ("image_2", "velodyne"),
    ("velodyne", "calib"),
)


def _beside(folders: Iterable[Path], root: Path, name: str) -> list[Path]:
    """Folders of that name in the root, in its halves, or beside them."""
    places = [root, *(folder.parent for folder in folders), root.absolute().parent]
    found = {(place / name).resolve(): place / name for place in places if (place / name).is_dir()}
    return list(found.values())
