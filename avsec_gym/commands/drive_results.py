"""What `avsec drive` writes beside rows and films: a summary, a page, a clip, a recording."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from avsec_gym.drives.scene_figures import shown_drives
from avsec_gym.drives.telling import by_scene, good, telling
from avsec_gym.json_schemas import with_schema
from avsec_gym.report.drives_page import drives_page
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.text_files import write_text

if TYPE_CHECKING:
    from avsec_gym.drawing.film_strip import ShownDrive
    from avsec_gym.drives.drive_folder import DriveFolder
    from avsec_gym.drives.summary import SettingSummary

PAGE, SUMMARY, CLIP = "drives.html", "summary.json", "drive"
"""Names of the files, of the clip and the recording without their suffix."""


@dataclass(frozen=True)
class DrivePictures:
    """How much is drawn.

    Args:
        strips: Most scenes with a bad end that the page shows as film strips; 0: no strips, and
            neither clip nor recording.
        video: Format of the clip of the most telling scene.
        rrd: Whether that scene is also written as a recording for Rerun.
    """

    strips: int
    video: Literal["gif", "mp4"]
    rrd: bool


def write_drive_results(
    folder: DriveFolder,
    summary: list[SettingSummary],
    record: dict[str, Any],
    pictures: DrivePictures,
) -> None:
    """Write the summary, the page, and the clip of the most telling scene.

    Args:
        folder: The drives; results are written into it, over earlier ones.
        summary: The summary of each setting.
        record: Everything that decides the results, for the page.
        pictures: How much is drawn.
    """
    report = with_schema("drive", {"settings": [each.to_json() for each in summary]})
    text = json.dumps(report, indent=1, allow_nan=False) + "\n"
    write_text(folder.out / SUMMARY, text, overwrite=True)
    page = drives_page(folder, summary, record, pictures.strips)
    write_text(folder.out / PAGE, page, overwrite=True)
    if not pictures.strips:
        return
    scenes = by_scene(folder.rows.values())
    drives = shown_drives(folder, [*telling(scenes), *good(scenes)][0])
    content = _clip(drives, pictures.video)
    write_bytes(folder.out / f"{CLIP}.{pictures.video}", content, overwrite=True)
    if pictures.rrd:
        from avsec_gym.drawing.rerun_drives import write_drives_recording

        write_drives_recording(drives, folder.out / f"{CLIP}.rrd")


def _clip(drives: list[ShownDrive], video: Literal["gif", "mp4"]) -> bytes:
    from avsec_gym.drawing.film_strip import RATE, clip, gif

    if video == "mp4":
        from avsec_gym.drawing.video import mp4

        return mp4(clip(drives), RATE)
    return gif(clip(drives))
