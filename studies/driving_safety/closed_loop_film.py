"""The film of the closed loop: one drive clean, under the laser, and defended.

Run ``python -m studies.driving_safety.closed_loop_film --drives DIR --gif FILE`` after
`avsec drive` with the settings ``detector``, ``attacked`` and ``defended``.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from avsec_gym.drawing.film_strip import clip, gif
from avsec_gym.drives.drive_folder import RECORD, DriveFolder
from avsec_gym.drives.scene_figures import shown_drives
from avsec_gym.drives.telling import DrivenScene, by_scene, how_bad
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.text_files import read_text
from studies.answer import exit_code
from studies.study import ROOT

FILM = "docs/images/closed_loop.gif"
SETTINGS = ("detector", "attacked", "defended")


def most_telling(scenes: Sequence[DrivenScene]) -> DrivenScene:
    """The scene in which the attack does most, and of these the defence most.

    Args:
        scenes: Scenes with a drive for each of `SETTINGS`, in this order.
    """

    def differences(scene: DrivenScene) -> tuple[int, int]:
        clean, attacked, defended = map(how_bad, scene.rows)
        return attacked - clean, attacked - defended

    return max(scenes, key=differences)


def film_lines() -> list[str]:
    """The film in docs/closed_loop.md, where it has been made."""
    if not (ROOT / FILM).is_file():
        return []
    return [
        f"![{', '.join(SETTINGS)}: one contested drive]({FILM.removeprefix('docs/')})",
        "",
        "The contested drive of [the study](../studies/results/closed_loop.md) in which the laser"
        " does most: the car alone, under the laser, and with a validator that stops it.",
    ]


def write_film(drives: Path, path: Path) -> None:
    """Write the film.

    Args:
        drives: A folder of `avsec drive`.
        path: The film, a GIF; an earlier one is written over.

    Raises:
        DataError: A drive is missing or damaged.
    """
    folder = DriveFolder(drives, json.loads(read_text(drives / RECORD)))
    scenes = by_scene(row for row in folder.rows.values() if row["setting"] in SETTINGS)
    ordered = [
        replace(
            scene, rows=tuple(sorted(scene.rows, key=lambda row: SETTINGS.index(row["setting"])))
        )
        for scene in scenes
        if len(scene.rows) == len(SETTINGS)
    ]
    shown = shown_drives(folder, most_telling(ordered))
    write_bytes(path, gif(clip(shown)), overwrite=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--drives", type=Path, required=True, help="folder of `avsec drive`")
    parser.add_argument("--gif", type=Path, required=True, help="the film")
    options = parser.parse_args(arguments)
    return exit_code(lambda: write_film(options.drives, options.gif))


if __name__ == "__main__":
    sys.exit(main())
