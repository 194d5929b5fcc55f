"""Which of KITTI's archives brings which folder, and archives that were unzipped apart.

Each archive holds the same ``training/`` or ``sequences/`` with another part in it.  They belong
unzipped into one folder; a tool that makes a folder of each archive's name keeps them apart, and
then no folder has a frame with all its sensors.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from avsec_gym.errors import DataError
from avsec_gym.kitti.raw import raw_parts
from avsec_gym.kitti.recording import subfolders
from avsec_gym.storage.regular_files import is_file, is_folder, is_there

ARCHIVES: dict[str, dict[str, str]] = {
    "object": {
        "label_2": "data_object_label_2.zip",
        "calib": "data_object_calib.zip",
        "image_2": "data_object_image_2.zip",
        "image_3": "data_object_image_3.zip",
        "velodyne": "data_object_velodyne.zip",
        "prev_2": "data_object_prev_2.zip",
        "prev_3": "data_object_prev_3.zip",
    },
    "tracking": {
        "label_02": "data_tracking_label_2.zip",
        "calib": "data_tracking_calib.zip",
        "image_02": "data_tracking_image_2.zip",
        "image_03": "data_tracking_image_3.zip",
        "velodyne": "data_tracking_velodyne.zip",
        "oxts": "data_tracking_oxts.zip",
    },
    "odometry": {
        "calib.txt": "data_odometry_calib.zip",
        "times.txt": "data_odometry_calib.zip",
        "image_0": "data_odometry_gray.zip",
        "image_1": "data_odometry_gray.zip",
        "image_2": "data_odometry_color.zip",
        "image_3": "data_odometry_color.zip",
        "velodyne": "data_odometry_velodyne.zip",
        "poses": "data_odometry_poses.zip",
    },
}
"""Archives by benchmark and part."""

_FRAMES = {
    "object": re.compile(r"[0-9]{6}(_0[1-3])?"),
    "tracking": re.compile(r"[0-9]{4}"),
}
"""How files and folders of a part are named."""
_NAMED = 3
"""So many parts of an archive are named."""


@dataclass(frozen=True)
class Apart:
    """Archives of one kind, each in a folder of its own.

    Args:
        where: The folder that holds those folders.
        parts: What each folder holds, by its name, such as ``training/label_2``.
        inside: What is to be merged in each folder, by its name, ``.`` for the folder itself.
    """

    where: Path
    parts: dict[str, tuple[str, ...]]
    inside: dict[str, str]

    @property
    def advice(self) -> str:
        """What there is, and how it is merged; two sentences and a command."""
        there = "; ".join(f"{name}/ has {_some(of)}" for name, of in self.parts.items())
        first, *others = (
            f"{name}/{inside}" if inside != "." else name for name, inside in self.inside.items()
        )
        target = shlex.quote(str(self.where / first))
        moves = " ".join(shlex.quote(f"{self.where / other}") + "/." for other in others)
        return (
            f"These archives were unzipped apart: {there}. They belong into one folder: "
            f"`cp -al {moves} {target}/` makes links of the files, so that no space is needed, and "
            f"then {first}/ is to be named."
        )


def archives_apart(root: Path) -> Apart | None:
    """Archives that lie side by side in a folder, or beside it, and belong together.

    Args:
        root: The folder that the user named: the one above the archives' folders, or one of them.

    Returns:
        None where fewer than two folders hold parts of one benchmark, or where what they hold is
        the same (then they are copies, or splits of someone's own).
    """
    for where in (root, root.absolute().parent):
        found = _apart_in(where)
        if found is not None and (where == root or root.absolute().name in found.parts):
            return found
    return None


def _apart_in(where: Path) -> Apart | None:
    kinds: dict[str, dict[str, tuple[str, tuple[str, ...]]]] = {}
    try:
        children = sorted(where.iterdir())
    except OSError:  # A folder above the user's need not be readable.
        return None
    for child in children:
        with suppress(DataError, OSError):  # Nor what lies beside it.
            for kind, inside, parts in _parts(child) if is_folder(child) else ():
                kinds.setdefault(kind, {})[child.name] = (inside, parts)
    for folders in kinds.values():
        every = [set(parts) for _, parts in folders.values()]
        if len(every) > 1 and not any(
            one & other for i, one in enumerate(every) for other in every[:i]
        ):
            return Apart(
                where,
                {name: parts for name, (_, parts) in folders.items()},
                {name: inside for name, (inside, _) in folders.items()},
            )
    return None


def _parts(folder: Path) -> Iterator[tuple[str, str, tuple[str, ...]]]:
    """What a folder holds of which benchmark: kind, the folder inside to merge, its parts."""
    for kind in ("object", "tracking"):
        there = [
            f"{half}/{name}"
            for half in ("training", "testing")
            for name in ARCHIVES[kind]
            if _holds(folder / half / name, kind)
        ]
        if there:
            yield kind, ".", tuple(there)
    for inside in ("dataset", "."):
        base = folder / inside
        first = next(iter(subfolders(base / "sequences", re.compile("[0-9]{2}")).values()), None)
        there = [name for name in ARCHIVES["odometry"] if first and is_there(first / name)]
        there += ["poses"] if is_file(base / "poses" / "00.txt") else []
        if there:
            yield "odometry", inside, tuple(there)
            break
    if parts := raw_parts(folder):
        yield "raw", ".", tuple(parts)


def _holds(part: Path, kind: str) -> bool:
    """Whether a part is of the benchmark: others have folders of the same names."""
    names = islice(part.iterdir(), 5) if is_folder(part) else ()
    return any(_FRAMES[kind].fullmatch(path.name.split(".")[0]) for path in names)


def _some(parts: tuple[str, ...]) -> str:
    more = f" and {len(parts) - _NAMED} more" if len(parts) > _NAMED else ""
    return ", ".join(parts[:_NAMED]) + more
