"""`avsec draw`: a picture of any scene."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from avsec_gym import console
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.storage.regular_files import is_there

_MOST_LAYOUTS = 100_000


@dataclass(frozen=True)
class Draw:
    """Draw an episode: lanes, objects believed and real, search tree, trajectory, collisions."""

    scene: Annotated[str, tyro.conf.Positional]
    """Its id, such as 000107 or street-000003."""
    scenarios: str | None = None
    """The set that it belongs to; see `avsec evaluate`.  Default: the labelled frames of --kitti;
    without it, `layouts`."""
    kitti: Path | None = None
    """Root of the KITTI object data (the folder that holds `training`)."""
    detections: Path | None = None
    """A detector's KITTI result folder: what the planner believes."""
    score_threshold: float | None = None
    """Detections below are dropped.  Default: as of `avsec evaluate`, from the whole folder."""
    motion: Literal["static", "truth"] | None = None
    """What the planner takes as moving.  Default: truth with ground truth, static with
    detections."""
    intention: Literal["left", "straight", "right"] = "straight"
    """Where to go."""
    planner: str = "astar"
    """Which search: astar or gbfs; or a plug-in's planner by its name, or JSON with arguments."""
    seed: int = 0
    """Seed of speeds and layouts."""
    out: Path | None = None
    """The PNG; or .rrd, a recording over time for the Rerun viewer (extra `rerun`).  Default: a PNG
    named after scene and intention, in this folder."""
    overwrite: bool = False
    """Replace a file that is there."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.commands.named_planner import named_planner
        from avsec_gym.commands.named_scenes import named_scenes
        from avsec_gym.drawing.scenario_picture import draw_episode, save_picture
        from avsec_gym.evaluation.files import episode_with_tree
        from avsec_gym.evaluation.rates import Detected
        from avsec_gym.kitti.detections import DetectionFolder
        from avsec_gym.scenario.intention import Intention
        from avsec_gym.scenario.scene import Motion
        from avsec_gym.scenario.scene_sets import LAYOUTS

        # The scene.
        _, planner = named_planner(self.planner)
        scenes = named_scenes(self.scenarios, self.kitti, seed=self.seed)
        known = {scene.id: scene for scene in scenes.scenes}
        are_layouts = self.scenarios == LAYOUTS or (self.scenarios is None and self.kitti is None)
        number = self.scene[-6:]
        if are_layouts and self.scene not in known and number.isdecimal():
            # Layouts beyond the first are as good; but they are made one after the other.
            count = int(number) + 1 if int(number) < _MOST_LAYOUTS else 1
            scenes = named_scenes(LAYOUTS, None, seed=self.seed, count=count)
            known = {scene.id: scene for scene in scenes.scenes}
        if self.scene not in known:
            raise ConfigurationError(
                f"{scenes.name} has no scene {self.scene!r}; it has {len(known)}, such as"
                f" {next(iter(known), 'none')!r}"
            )
        # What is planned on: the truth, or the detections in this scene.
        believed, motion = None, Motion.TRUTH
        if self.detections is not None:
            boxes, missing = DetectionFolder(self.detections).read(known)
            if self.scene in missing:
                console.say(
                    f"avsec: {self.detections}: {self.scene} has no file and counts as without "
                    "detections"
                )
            detected = Detected(boxes, self.score_threshold)
            believed, motion = detected.kept()[self.scene], Motion.STATIC
        if self.motion is not None:
            motion = Motion(self.motion)
        shown = episode_with_tree(
            known[self.scene], Intention(self.intention), believed, motion, planner
        )
        # A picture, or a recording, by the name of the file.
        path = self.out or Path(f"{self.scene}_{self.intention}.png")
        if path.suffix == ".rrd":
            from avsec_gym.drawing.rerun_scene import write_scene_recording

            if is_there(path) and not self.overwrite:
                raise DataError(
                    "the file exists.", path=path, remedy="Name another, or use --overwrite."
                )
            write_scene_recording(shown, path)
        else:
            save_picture(draw_episode(shown), path, overwrite=self.overwrite)
        console.say(f"{path}: {shown.record.outcome}; {shown.plan.explanation}")
        return console.DONE
