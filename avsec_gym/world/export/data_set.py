"""Makes a data set in a folder: what is there is kept, what is missing is made, all is listed."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.progress import Progress
from avsec_gym.storage.folder_lock import locked_folder
from avsec_gym.storage.regular_files import is_file
from avsec_gym.world.export.manifest import (
    check_same,
    list_files,
    new_manifest,
    read_manifest,
    sweep,
    write_manifest,
)
from avsec_gym.world.export.recipe import Recipe
from avsec_gym.world.export.workers import make_frames, usual_workers


@dataclass(frozen=True)
class DataSetReport:
    """What was done."""

    root: Path
    made: int
    """Frames made now."""
    kept: int
    """Frames that were there."""
    left_out: int = 0
    """Frames whose sources are broken; each has its remark."""
    remarks: tuple[str, ...] = ()
    """Remarks on the frames made now."""


def make_data_set(
    recipe: Recipe,
    root: str | Path,
    *,
    workers: int | None = None,
    on_progress: Progress | None = None,
) -> DataSetReport:
    """Make a data set, or complete one.

    May be killed at any time and started again: frames whose last file is there are kept. The
    files do not depend on the number of workers, nor on interruptions. A set of more frames
    continues one of fewer; frames beyond those asked for are kept.

    Args:
        recipe: The recipe of the data set.
        root: Folder of the data set: new, empty, or with the same data set.
        workers: Number of processes; two if None (one where there is one processor).
        on_progress: Function that gets the numbers of frames done and of all frames.

    Raises:
        ConfigurationError: No frames or workers are asked for.
        DataError: The folder holds something else, is being written by another process, or
            cannot be written.
    """
    if workers is not None and workers < 1:
        raise ConfigurationError(f"1 worker or more, got {workers}")
    if not len(recipe):
        raise ConfigurationError("a data set has 1 frame or more, got none")
    with locked_folder(root) as root:
        manifest, asked = read_manifest(root), new_manifest(recipe.settings)
        if manifest is None:
            _check_empty(root)
        else:
            check_same(root, manifest, asked)
            sweep(root)
        missing = _missing(recipe, root)
        kept = len(recipe) - len(missing)
        if manifest is not None and manifest["complete"] and not missing:
            _check_sizes(root, manifest["files"])
            return DataSetReport(root, 0, kept)
        write_manifest(root, asked)
        remarks: dict[int, list[str]] = {}
        with closing(make_frames(recipe, root, missing, workers or usual_workers())) as frames:
            for done, (number, noted) in enumerate(frames, start=kept + 1):
                remarks[number] = noted
                if on_progress is not None:
                    on_progress(done, len(recipe))
        said = tuple(remark for number in sorted(remarks) for remark in remarks[number])
        left_out = len(_missing(recipe, root))
        if left_out == len(recipe):
            raise DataError(f"No frame could be made. {said[0]}", path=root)
        recipe.finish(root)
        frames_there = sum(1 for _ in root.glob(recipe.last_files))
        asked |= {"complete": True, "frames": frames_there, "files": list_files(root)}
        write_manifest(root, asked)
    return DataSetReport(root, len(missing) - left_out, kept, left_out, said)


def _missing(recipe: Recipe, root: Path) -> list[int]:
    return [i for i in range(len(recipe)) if not is_file(root / recipe.last_file(i))]


def _check_empty(root: Path) -> None:
    there = sorted(path.name for path in root.iterdir() if not path.name.startswith("."))
    if there:
        raise DataError(
            f"The folder is not empty ({there[0]}) and has no manifest of a data set.",
            path=root,
            remedy="Name a new or empty folder; nothing is overwritten.",
        )


def _check_sizes(root: Path, files: dict[str, dict[str, int]]) -> None:
    for name, facts in files.items():
        path = root / name
        if not is_file(path) or path.stat().st_size != facts["bytes"]:
            raise DataError(
                "The file is missing or has another size than the manifest states.",
                path=path,
                remedy="Remove the label file of its frame and run the command again to have the "
                "frame made anew, or remove the folder.",
            )
