"""Scenes cut from KITTI's recordings: tracking sequences, and raw drives with tracklets."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path

from avsec_gym.closed_loop.recorded.raw_traffic import drive_traffic
from avsec_gym.closed_loop.recorded.recorded_scene import recorded_scene, scene_id
from avsec_gym.closed_loop.recorded.recorded_traffic import RecordedTraffic
from avsec_gym.closed_loop.recorded.sources import EVERY, KITTI_RAW, KITTI_TRACKING
from avsec_gym.closed_loop.recorded.tracking_traffic import sequence_traffic
from avsec_gym.closed_loop.recorded.windows import KnownMotion, Refusal, known_motion
from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.errors import DataError
from avsec_gym.kitti.raw import TRACKLETS, KittiRaw
from avsec_gym.kitti.tracking_sequences import LABELS, KittiTracking
from avsec_gym.storage.regular_files import is_file

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class RecordedWindows:
    """The windows of one recording.

    Args:
        known: The recording and its car's motion.
        starts: First frames of the windows to drive in.
        refused: Why other windows are not driven in, and how many.
    """

    known: KnownMotion
    starts: tuple[int, ...]
    refused: Counter[Refusal]


def recorded_windows(source: str, root: str | Path, every: float = EVERY) -> list[RecordedWindows]:
    """The windows of all recordings in a folder.

    Args:
        source: `KITTI_TRACKING` or `KITTI_RAW`.
        root: Root of the benchmark's data.
        every: Seconds from the start of one window to the next.

    Raises:
        DataError: There is no recording, or a file is broken.
    """
    recordings = _RECORDINGS[source](Path(root))
    windows = []
    for id in recordings:
        known = _known(source, str(root), id)
        starts, refused = known.starts(every)
        windows.append(RecordedWindows(known, tuple(starts), refused))
        reasons = "; ".join(f"{reason} ({count})" for reason, count in refused.most_common())
        _log.info("%s: %d windows; refused: %s", id, len(starts), reasons or "none")
    return windows


def recorded_scenes(
    source: str,
    root: str | Path,
    *,
    every: float = EVERY,
    count: int | None = None,
    people: bool = True,
) -> dict[str, Callable[[], TrafficScene]]:
    """What makes the scenes of all windows of 8 s of all recordings in a folder, by their ids.

    Args:
        source: `KITTI_TRACKING` or `KITTI_RAW`.
        root: Root of the benchmark's data.
        every: Seconds from the start of one window to the next.
        count: Number of scenes, spread evenly over all; None: all.
        people: Whether pedestrians and cyclists are there.

    Raises:
        DataError: There is no recording with a window to drive in, or a file is broken.
    """
    windows = recorded_windows(source, root, every)
    places = [(each, first) for each in windows for first in each.starts]
    if not places:
        reasons = sum((each.refused for each in windows), Counter[Refusal]())
        raise DataError(
            "No window of 8 s can be driven in: "
            + "; ".join(f"{reason} ({number})" for reason, number in reasons.most_common())
            + ".",
            path=root,
            remedy="Add recordings, or their oxts, with which the car's motion is known.",
        )
    if count is not None and count < len(places):
        places = [places[(2 * i + 1) * len(places) // (2 * count)] for i in range(count)]
    return {
        scene_id(each.known.recording.id, first): lru_cache(1)(
            partial(recorded_scene, each.known, first, people=people)
        )
        for each, first in places
    }


@lru_cache(maxsize=64)
def _known(source: str, root: str, id: str) -> KnownMotion:
    """A recording's motion, estimated once in a process."""
    return known_motion(_RECORDINGS[source](Path(root))[id]())


def _tracking(root: Path) -> Mapping[str, Callable[[], RecordedTraffic]]:
    data = KittiTracking(root)
    labelled = {
        name: partial(sequence_traffic, data.sequence(name))
        for name in data.sequences()
        if is_file(data.folder / LABELS / f"{name}.txt")
    }
    if not labelled:
        raise DataError(
            f"None of the {len(data.sequences())} sequences has labels.",
            path=root,
            remedy="Fetch the training labels of the tracking benchmark.",
        )
    return labelled


def _raw(root: Path) -> Mapping[str, Callable[[], RecordedTraffic]]:
    data = KittiRaw(root)
    drives = {name: data.drive(name) for name in data.drives()}
    labelled = {
        name: partial(drive_traffic, drive)
        for name, drive in drives.items()
        if is_file(drive.folder / TRACKLETS)
    }
    if not labelled:
        raise DataError(
            f"None of the {len(drives)} drives has tracklets.",
            path=root,
            remedy=f"KITTI labelled some drives only; fetch a drive's {TRACKLETS}.",
        )
    return labelled


_RECORDINGS: dict[str, Callable[[Path], Mapping[str, Callable[[], RecordedTraffic]]]] = {
    KITTI_TRACKING: _tracking,
    KITTI_RAW: _raw,
}
