"""The labelled KITTI scenarios of the benchmark's version, which are read where the user has them.

They cannot be given on: the version holds the names and hashes of their files alone, and which
intentions were contested in each when it was frozen.  Results of detectors on KITTI's own frames
are entered on them.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TypedDict

from avsec_gym.benchmark.scene_sets import VERSION
from avsec_gym.boxes import Boxes3D
from avsec_gym.errors import DataError
from avsec_gym.kitti.labels import read_labels
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene_set import SceneSet
from avsec_gym.scenario.scene_sets import labelled_scenarios
from avsec_gym.storage.json_fields import check_fields
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.storage.regular_files import MAX_TEXT_BYTES, is_file, is_folder, read_bytes

KITTI, KITTI_CONTESTED = "kitti", "kitti_contested"
"""Names of the set, and of its scenes and intentions that are contested."""
FROZEN = f"kitti_{VERSION}.json"
"""What is frozen, beside this module; ``benchmarks/freeze_kitti.py`` writes it."""
FOLDERS = (
    "static_label",
    "dynamic_label",
    "dynamic_annotation",
    "road_dynamic_label",
    "road_dynamic_annotation",
    "nocar",
)
"""The folders of the labelled scenarios that are read."""
_DIGITS = 16
_HASH = re.compile(rf"[0-9a-f]{{{_DIGITS}}}")
_REMEDY = "It belongs to the package: install it again."
_NAMED = 3
"""So many files that differ are named in an error."""


class _Frozen(TypedDict):
    """What the file holds."""

    files: dict[str, str]
    contested: dict[str, list[str]]


@dataclass(frozen=True)
class FrozenLabels:
    """Labelled scenarios, by their files.

    Args:
        files: What `hashes_of` made of each file when they were frozen, by its place.
        contested: The contested intentions by scene, of the scenes that have some.
    """

    files: Mapping[str, str]
    contested: Mapping[str, frozenset[Intention]]

    @property
    def digest(self) -> str:
        """Sixteen hexadecimal digits that stand for all files and what is contested."""
        lines = [f"{name} {content}" for name, content in sorted(self.files.items())]
        lines += [f"{id} {' '.join(sorted(ways))}" for id, ways in sorted(self.contested.items())]
        return hashlib.sha256("\n".join(lines).encode()).hexdigest()[:16]

    def scenes(self, root: Path) -> SceneSet:
        """The scenes, if the user's files are the frozen ones.

        Args:
            root: The folder of the labelled scenarios, see `labelled_scenarios`.

        Raises:
            DataError: A file is missing, another one is there, or one has other content.
        """
        if not is_folder(root):
            raise DataError(
                "There is no such folder.",
                path=root,
                remedy="Name the folder of the labelled scenarios with --labels.",
            )
        found = hashes_of(root)
        other = sorted(
            name for name in {*found, *self.files} if found.get(name) != self.files.get(name)
        )
        if other:
            names = ", ".join(other[:_NAMED]) + (" ..." if len(other) > _NAMED else "")
            raise DataError(
                f"{len(other)} of the {len(self.files)} files of version {VERSION} of the benchmark"
                f" are missing here, have other content, or do not belong to it: {names}.",
                path=root,
                remedy="Name the folder of the labelled scenarios as they are published.",
            )
        return replace(labelled_scenarios(root), name=KITTI)

    def truth(self, root: Path) -> dict[str, Boxes3D]:
        """What is to be found in each scene's frame, with the regions not to care about.

        Args:
            root: The folder of the labelled scenarios.

        Raises:
            DataError: A file is missing or broken.
        """
        names = (name for name in self.files if "annotation" not in name)
        return {Path(name).stem: read_labels(root / name, keep_dont_care=True) for name in names}

    def of_contested(self, scenes: SceneSet) -> SceneSet:
        """The contested scenes and intentions of a set."""
        kept = tuple(scene for scene in scenes.labelled if scene.id in self.contested)
        return replace(scenes, name=KITTI_CONTESTED, scenes=kept, intentions=self.contested)


@cache
def frozen_labels() -> FrozenLabels:
    """The labelled scenarios of this version."""
    return read_frozen_labels(Path(__file__).with_name(FROZEN))


def read_frozen_labels(path: Path) -> FrozenLabels:
    """Read what ``benchmarks/freeze_kitti.py`` wrote.

    Raises:
        DataError: Missing or damaged: a file without its hash, an intention that is none, or a
            contested scene without files.
    """
    found = read_json_object(path, remedy=_REMEDY)
    try:
        check_fields(_Frozen, found)
        if wrong := [name for name, hash in found["files"].items() if not _HASH.fullmatch(hash)]:
            raise ValueError(f"{wrong[0]} has no hash of {_DIGITS} digits")
        ways = {id: frozenset(map(Intention, own)) for id, own in found["contested"].items()}
        if strangers := ways.keys() - {Path(name).stem for name in found["files"]}:
            raise ValueError(f"the contested scene {min(strangers)} has no files")
    except ValueError as error:
        raise DataError(f"The file is damaged: {error}.", path=path, remedy=_REMEDY) from error
    return FrozenLabels(found["files"], ways)


def hashes_of(root: Path) -> dict[str, str]:
    """Sixteen hexadecimal digits of SHA-256 of each label and flag file, by its place.

    Args:
        root: The folder of the labelled scenarios.

    Raises:
        DataError: A file cannot be read.
    """
    files = sorted(path for name in FOLDERS for path in (root / name).glob("*.txt"))
    return {path.relative_to(root).as_posix(): _hash(path) for path in files if is_file(path)}


def _hash(path: Path) -> str:
    return hashlib.sha256(read_bytes(path, most=MAX_TEXT_BYTES)).hexdigest()[:_DIGITS]
