"""What a look through a folder of data found, and the collecting of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from avsec_gym.errors import DataError
from avsec_gym.kitti.layouts import KittiLayout
from avsec_gym.progress import Progress

Sizes = dict[str, tuple[int, int]]
"""Width and height of images by the stem of their names."""
FileCheck = Callable[[Path, Counter[str], Sizes], None]
"""Looks at a file; adds its objects by category, and its size if it is an image."""


@dataclass(frozen=True)
class LayoutFolder:
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
    """What `avsec_gym.kitti.check.check_data` found."""

    root: str
    layout: KittiLayout
    parts: tuple[LayoutFolder, ...] = ()
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


@dataclass(frozen=True)
class Files:
    """Files of one folder that are looked at alike."""

    folder: Path
    paths: Sequence[Path]
    look: FileCheck


class Survey:
    """Collects what is found on the way; what is broken does not stop it."""

    def __init__(self, root: Path, layout: KittiLayout, on_progress: Progress | None) -> None:
        self.root, self.layout, self._on_progress = root, layout, on_progress
        self.parts: list[LayoutFolder] = []
        self.gaps: list[Gap] = []
        self.broken: list[BrokenFile] = []
        self.notes: list[str] = [layout.description]
        self.sizes: dict[Path, Sizes] = {}
        """Sizes of images by folder."""

    def look_at(self, groups: Sequence[Files]) -> None:
        """Look at every file; each group becomes a part."""
        total, done = sum(len(group.paths) for group in groups), 0
        for group in groups:
            before = len(self.broken)
            objects: Counter[str] = Counter()
            sizes: Sizes = {}
            for path in group.paths:
                try:
                    group.look(path, objects, sizes)
                except DataError as error:
                    self.add(error)
                done += 1
                if self._on_progress is not None:
                    self._on_progress(done, total)
            self.sizes[group.folder] = sizes
            images = Counter(f"{width}x{height}" for width, height in sizes.values())
            broken = len(self.broken) - before
            name = self.name(group.folder)
            self.parts.append(
                LayoutFolder(name, len(group.paths), broken, dict(objects), dict(images))
            )

    def add(self, error: DataError) -> None:
        """Something is broken."""
        self.broken.append(BrokenFile(error.path, error.line, error.problem, error.remedy))

    def note_others(self, folder: Path, others: Sequence[Path]) -> None:
        """What lies in a folder of frames and is none."""
        if others:
            self.notes.append(
                f"{self.name(folder)} holds {len(others)} entries that are no frames, "
                f"such as {others[0].name!r}."
            )

    def compare(
        self, has: str, frames: Collection[str], lacks: str, others: Collection[str]
    ) -> None:
        """Report the frames that the first has and the second lacks."""
        lacking = sorted(set(frames) - set(others))
        if lacking:
            self.gaps.append(Gap(has, lacks, len(lacking), tuple(lacking[:3])))

    def compare_sizes(self, left: Path, right: Path) -> None:
        """Report the images of a right camera that have not the left one's size."""
        ones: Mapping[str, tuple[int, int]] = self.sizes.get(left, {})
        others = self.sizes.get(right, {})
        for stem in sorted(ones.keys() & others.keys()):
            if ones[stem] != others[stem]:
                problem = f"The right image has {others[stem]} pixels, the left one {ones[stem]}."
                path = right / f"{stem}.png"
                self.add(DataError(problem, path=path, remedy="Fetch both again."))

    def name(self, path: Path) -> str:
        """A file or folder, relative to the root as the user named it."""
        if path == self.root or not path.is_relative_to(self.root):
            return path.name
        return str(path.relative_to(self.root))

    def report(self) -> DataReport:
        """All of it."""
        gaps, broken, notes = tuple(self.gaps), tuple(self.broken), tuple(self.notes)
        return DataReport(str(self.root), self.layout, tuple(self.parts), gaps, broken, notes)
