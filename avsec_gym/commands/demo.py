"""`avsec demo`: the main job on the embedded default, from nothing."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from avsec_gym.commands import console
from avsec_gym.errors import ConfigurationError

if TYPE_CHECKING:
    from avsec_gym.experiments.ghost_attack import AttackedDrive


@dataclass(frozen=True)
class Demo:
    """Drive procedural street and highway scenes, attack the detections, show what happens."""

    out: Path = Path("runs/demo")
    """Folder for demo.json and the pictures; a demo's own files there are replaced."""
    scenes: int = 200
    """How many scenes, each driven left, straight and right."""
    seed: int = 0
    """Of the scenes and the attack."""
    json: bool = False
    """Print JSON instead of tables."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.experiments.ghost_attack import ghost_attack, summary
        from avsec_gym.scenario.scene_sets import procedural_scenes

        if self.scenes < 1:
            raise ConfigurationError(f"--scenes is 1 or more, got {self.scenes}")
        scenes = procedural_scenes(self.scenes, seed=self.seed)
        with console.progress("driving and attacking") as shown:
            drives = ghost_attack(scenes, on_progress=shown)
        report = summary(drives)
        self.out.mkdir(parents=True, exist_ok=True)
        (self.out / "demo.json").write_text(json.dumps(report, indent=1) + "\n")
        pictures = _draw(drives, self.out)
        if self.json:
            console.print_json(report)
            return console.DONE
        console.print_table(
            f"{self.scenes} procedural scenes, A*, % with 95 % Wilson intervals",
            ["intention", "detections", "success", "collision", "safe driving"],
            [
                [
                    row["intention"],
                    "true" if row["input"] == "ground_truth" else "attacked by 2 ghosts",
                    *(
                        console.percent(row[name], row[f"{name}_interval"])
                        for name in ("success_rate", "collision_rate", "safe_driving_rate")
                    ),
                ]
                for row in report["rates"]
            ],
        )
        console.say(f"{len(pictures)} pictures, such as {pictures[0]}, and {self.out}/demo.json")
        return console.DONE


def _draw(drives: list[AttackedDrive], folder: Path) -> list[Path]:
    """A street and a highway, as they are and attacked; the sheet of both."""
    from avsec_gym.experiments.driving_safety.files import drive_with_tree
    from avsec_gym.report.scenario_picture import draw_drive, draw_sheet, save_picture
    from avsec_gym.scenario.scene import Motion

    turned = [each for each in drives if each.clean.safe and not each.attacked.safe]
    # Where much goes on, there is more to see.
    turned.sort(key=lambda each: -len(each.scene.boxes))
    chosen = []
    for road_type in ("street", "highway"):
        chosen += [each for each in turned if each.scene.road_type == road_type][:1]
    files, all_drives = [], []
    for each in chosen or turned[:1] or drives[:1]:
        for name, believed in (("clean", None), ("attacked", each.believed)):
            shown = drive_with_tree(each.scene, each.intention, believed, Motion.TRUTH)
            all_drives.append(shown)
            files.append(folder / f"{each.scene.road_type}_{name}.png")
            save_picture(draw_drive(shown), files[-1], overwrite=True)
    sheet = folder / "demo.png"
    save_picture(draw_sheet(all_drives), sheet, overwrite=True)
    return [sheet, *files]
