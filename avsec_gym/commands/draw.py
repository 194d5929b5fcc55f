"""`avsec draw`: a picture of any scene."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from avsec_gym.commands import console
from avsec_gym.errors import ConfigurationError


@dataclass(frozen=True)
class Draw:
    """Draw a drive: lanes, objects believed and real, search tree, trajectory, verdict."""

    scene: Annotated[str, tyro.conf.Positional]
    """Its id, such as 000107 or street-000003."""
    scenarios: str = "layouts"
    """The set that it belongs to; see `avsec evaluate`."""
    kitti: Path | None = None
    """Root of the KITTI object data, where --scenarios is a list of ids."""
    detections: Path | None = None
    """A detector's KITTI result folder: what the planner believes."""
    score_threshold: float = float("-inf")
    """Detections below are dropped."""
    intention: Literal["left", "straight", "right"] = "straight"
    """Where to go."""
    planner: Literal["astar", "gbfs"] = "astar"
    """Which search."""
    seed: int = 0
    """Of speeds and layouts."""
    out: Path | None = None
    """The PNG; default: named after scene and intention, in this folder."""
    overwrite: bool = False
    """Replace a file that is there."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.experiments.driving_safety_files import drive_with_tree
        from avsec_gym.kitti.detections import DetectionFolder, above
        from avsec_gym.planners.planner import Algorithm
        from avsec_gym.report.scenario_picture import draw_drive, save_picture
        from avsec_gym.scenario.intention import Intention
        from avsec_gym.scenario.scene import Motion
        from avsec_gym.scenario.scene_sets import scene_set

        scenes = scene_set(self.scenarios, kitti=self.kitti, seed=self.seed)
        known = {scene.id: scene for scene in scenes.scenes}
        if self.scene not in known:
            raise ConfigurationError(
                f"{scenes.name} has no scene {self.scene!r}; it has {len(known)}, such as"
                f" {next(iter(known), 'none')!r}"
            )
        believed, motion = None, Motion.TRUTH
        if self.detections is not None:
            boxes, _ = DetectionFolder(self.detections).read([self.scene])
            believed, motion = above(boxes[self.scene], self.score_threshold), Motion.STATIC
        shown = drive_with_tree(
            known[self.scene], Intention(self.intention), believed, motion, Algorithm(self.planner)
        )
        path = self.out or Path(f"{self.scene}_{self.intention}.png")
        save_picture(draw_drive(shown), path, overwrite=self.overwrite)
        console.say(f"{path}: {shown.record.outcome}; {shown.plan.explanation}")
        return console.DONE
