"""`avsec data check`: what is there, what is missing, what is broken."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from avsec_gym import console

if TYPE_CHECKING:
    from avsec_gym.kitti.report import LayoutFolder


@dataclass(frozen=True)
class DataCheck:
    """Look through a data folder in one of KITTI's layouts, or a result folder."""

    root: Annotated[Path, tyro.conf.Positional]
    """The folder."""
    deep: bool = False
    """Decode every image and scan, too."""
    json: bool = False
    """Print JSON instead of tables."""

    def run(self) -> int:
        """Do it; the exit code: 1 where something is broken."""
        from avsec_gym.kitti.check import check_data

        root = _place(self.root)
        with console.progress("checking") as shown:
            report = check_data(root, deep=self.deep, on_progress=shown)
        if self.json:
            console.print_json("data.check", report.to_json())
        else:
            rows = [
                [part.folder, str(part.files), str(part.broken), _contents(part)]
                for part in report.parts
            ]
            title = f"{root}: {report.layout.description}"
            console.print_table(title, ["folder", "files", "broken", "holds"], rows)
            for note in report.notes:
                if note != report.layout.description:
                    console.say(f"note: {note}")
            for gap in report.gaps:
                console.say(f"missing: {gap}")
            for broken in report.broken:
                console.say(f"broken: {broken}")
            if report.ok:
                console.say("nothing is broken")
        return console.DONE if report.ok else console.BAD_DATA


def _place(root: Path) -> Path:
    """The folder itself; or, as other commands take it, that of the result files below it."""
    from avsec_gym.errors import DataError
    from avsec_gym.kitti.layouts import KittiLayout, recognise
    from avsec_gym.kitti.result_place import result_folder

    if recognise(root) is not KittiLayout.UNKNOWN:
        return root
    try:
        below = result_folder(root)
    except DataError:
        return root
    return below if recognise(below) is KittiLayout.DETECTIONS else root


def _contents(part: LayoutFolder) -> str:
    counts = part.objects or part.image_sizes
    return ", ".join(f"{name} {count}" for name, count in counts.items())
