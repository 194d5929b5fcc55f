"""`avsec evaluate`: the thesis' three driving-safety rates."""

from __future__ import annotations

import json
import math
from contextlib import nullcontext
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from avsec_gym import console
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.json_schemas import with_schema
from avsec_gym.storage.regular_files import is_folder, is_there

if TYPE_CHECKING:
    from avsec_gym.boxes import Boxes3D
    from avsec_gym.evaluation.rates import Detected, DrivingSafety
    from avsec_gym.planners.planner import Planner
    from avsec_gym.scenario.scene_set import SceneSet


@dataclass(frozen=True)
class Evaluate:
    """Success, collision and safe-driving rate with ground truth, and with a detector's results."""

    kitti: Path | None = None
    """Root of the KITTI object data (the folder that holds `training`)."""
    scenarios: str | None = None
    """Which scenes: a folder of the labelled scenarios, a folder of KITTI label files (with a
    folder `flags`), a folder of CommonRoad files (their own goals; --intention is not used), a
    list of frame ids (with --kitti), `layouts`, or contested scenes, in which it matters what a car
    sees: `mixed_contested` of these layouts, `kitti_contested` of the labels in the folder --kitti.
    Default: every labelled frame of --kitti; without it, `layouts`."""
    split: str | None = None
    """Frames of --kitti, without --scenarios: those of ImageSets/SPLIT.txt, such as val, or of a
    .txt file that lists frame ids.  Each of them counts, with or without a result file."""
    detections: Path | None = None
    """A detector's KITTI result folder; its boxes are what the planner believes."""
    planner: str = "astar"
    """Which search: astar, gbfs, all for both; or a plug-in's planner by its name, or JSON with
    arguments."""
    intention: Literal["left", "straight", "right", "all"] = "all"
    """Where to go."""
    score_threshold: float | None = None
    """Detections below are dropped.  Default: 0.3 where all scores are probabilities, else 0."""
    motion: Literal["static", "truth", "classifier"] | None = None
    """What the planner takes as moving: nothing, what really moves, or the detections that the
    moving-object classifier finds (needs --kitti with images).  Default: truth with ground
    truth in, static with detections."""
    seed: int = 0
    """Moving objects draw their speeds from it; so do procedural layouts."""
    draw_start_speed: bool = False
    """Draw the start speed from the thesis' range instead of the authors' 6 and 11 m/s."""
    limit: int | None = None
    """Only the first scenes (of `layouts`: how many; default 200)."""
    sweep: int = 0
    """Report the rates at so many score thresholds as well (quantiles of the scores)."""
    out: Path | None = None
    """Folder for evaluation.json, a CSV of all records, and pictures of what became unsafe."""
    pictures: int = 24
    """Most pictures in --out."""
    json: bool = False
    """Print JSON instead of tables."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.storage.folder_lock import locked_folder

        # What can be refused before anything is read.
        if self.limit is not None and self.limit < 1:
            raise ConfigurationError(f"--limit is 1 or more, got {self.limit}")
        if self.sweep < 0 or self.pictures < 0:
            raise ConfigurationError("--sweep and --pictures are 0 or more")
        if self.score_threshold is not None and not math.isfinite(self.score_threshold):
            raise ConfigurationError(
                f"--score-threshold is a finite number, got {self.score_threshold}"
            )
        if self.out is not None and is_there(self.out) and not is_folder(self.out):
            raise DataError("this is a file.", path=self.out, remedy="Name a folder with --out.")
        if self.out is not None and is_there(self.out / "evaluation.json"):
            raise DataError(
                "an evaluation is here already.",
                path=self.out,
                remedy="Name another folder with --out; nothing is overwritten.",
            )
        with nullcontext() if self.out is None else locked_folder(self.out):
            return self._evaluated()

    def _evaluated(self) -> int:
        """Drive, report and write; the exit code."""
        from avsec_gym.evaluation.rates import driving_safety
        from avsec_gym.scenario.intention import Intention
        from avsec_gym.scenario.scene import Motion

        # The scenes, and what is detected in them.
        planners = self._planners
        scenes = self._scenes()
        scenes, detected = self._detected(scenes)
        for remark in scenes.remarks:
            console.say(f"avsec: {remark}")
        # Drive all of them.
        known = None if self.motion is None else Motion(self.motion)
        with console.progress("driving") as shown:
            result = driving_safety(
                scenes,
                planners=tuple(planners),
                planner_of=planners.__getitem__,
                intentions=(
                    tuple(Intention) if self.intention == "all" else (Intention(self.intention),)
                ),
                detected=detected,
                truth_motion=Motion.TRUTH if known in (None, Motion.CLASSIFIER) else known,
                detected_motion=known or Motion.STATIC,
                on_progress=shown,
            )
        # Report.
        report = with_schema("evaluate", result.to_json())
        report["settings"] |= self._settings()
        if self.sweep and detected is not None:
            report["sweep"] = self._sweep(scenes, detected)
        if self.out is not None:
            self._write(result, report, detected)
        if self.json:
            console.print_json("evaluate", report)
        else:
            _show(report)
        in_part = scenes.skipped or (detected is not None and detected.missing)
        return console.DONE_IN_PART if in_part else console.DONE

    @cached_property
    def _planners(self) -> dict[str, Planner]:
        from avsec_gym.commands.named_planner import named_planners

        return named_planners(self.planner)

    def _settings(self) -> dict[str, Any]:
        """What was asked for, and of which version."""
        from dataclasses import asdict

        from avsec_gym import __version__

        asked = {
            name: str(value) if isinstance(value, Path) else value
            for name, value in asdict(self).items()
            if name not in ("json", "motion", "score_threshold")
        }
        return asked | {"version": __version__}

    def _scenes(self) -> SceneSet:
        from dataclasses import replace

        from avsec_gym.commands.named_scenes import named_scenes

        scenes = named_scenes(
            self.scenarios, self.kitti, seed=self.seed, count=self.limit, split=self.split
        )
        if not len(scenes):
            raise DataError(
                "there is no scene to drive.",
                path=self.scenarios or self.kitti,
                remedy="Name a folder with label files.",
            )
        if self.draw_start_speed:
            drawn = tuple(replace(scene, draw_start_speed=True) for scene in scenes.labelled)
            scenes = replace(scenes, scenes=drawn)
        return scenes

    def _detected(self, scenes: SceneSet) -> tuple[SceneSet, Detected | None]:
        """The detections, and the scenes without those whose result file is broken."""
        from avsec_gym.evaluation.rates import Detected
        from avsec_gym.kitti.detections import DetectionFolder
        from avsec_gym.kitti.label_folders import is_id

        if self.detections is None:
            if self.score_threshold is not None or self.sweep or self.motion == "classifier":
                raise ConfigurationError(
                    "--score-threshold, --sweep and --motion classifier belong to --detections"
                )
            return scenes, None
        ids = [scene.id for scene in scenes.scenes]
        if not all(map(is_id, ids)):
            raise ConfigurationError(
                f"--detections belong to KITTI frames; {scenes.name} has scenes such as {ids[0]!r}"
            )
        broken: dict[str, DataError] = {}
        boxes, missing = DetectionFolder(self.detections).read(ids, broken)
        if broken and not boxes:
            raise next(iter(broken.values()))
        if missing:
            names = ", ".join(missing[:5]) + (" ..." if len(missing) > 5 else "")
            console.say(
                f"avsec: {self.detections}: {len(missing)} of {len(ids)} frames have no file and"
                f" count as without detections: {names}"
            )
        if self.motion == "classifier":
            boxes = self._classified(boxes, broken)
        return scenes.without(broken), Detected(boxes, self.score_threshold, tuple(missing))

    def _classified(
        self, boxes: dict[str, Boxes3D], broken: dict[str, DataError]
    ) -> dict[str, Boxes3D]:
        """The detections with C's view of their motion; frames that cannot be read are noted."""
        from avsec_gym.kitti.dataset import KittiObject
        from avsec_gym.registry import Kind, make

        if self.kitti is None:
            raise ConfigurationError("--motion classifier looks at images: name their --kitti ROOT")
        data, classifier = KittiObject(self.kitti), make(Kind.CLASSIFIER, "small")
        result = {}
        with console.progress("classifying") as shown:
            for done, (id, detected) in enumerate(boxes.items(), start=1):
                try:
                    result[id] = classifier.classify(detected, data.frame(id))
                except DataError as error:
                    broken[id] = error
                shown(done, len(boxes))
        if broken and not result:
            raise next(iter(broken.values()))
        return result

    def _sweep(self, scenes: SceneSet, detected: Detected) -> list[dict[str, Any]]:
        import numpy as np

        from avsec_gym.evaluation.rates import threshold_sweep
        from avsec_gym.scenario.intention import Intention
        from avsec_gym.scenario.scene import Motion

        quantiles = np.linspace(0, 1, self.sweep, endpoint=False)
        return threshold_sweep(
            scenes,
            detected,
            np.quantile(detected.all_scores, quantiles),
            planner=next(iter(self._planners)),
            planner_of=self._planners.__getitem__,
            intentions=tuple(Intention)
            if self.intention == "all"
            else (Intention(self.intention),),
            motion=Motion(self.motion or "static"),
        )

    def _write(
        self, result: DrivingSafety, report: dict[str, Any], detected: Detected | None
    ) -> None:
        from avsec_gym.evaluation.files import write_pictures, write_records
        from avsec_gym.storage.text_files import write_text

        assert self.out is not None
        write_records(result, self.out / "records.csv")
        with console.progress("drawing") as shown:
            write_pictures(
                result,
                detected,
                self.out / "pictures",
                self.pictures,
                shown,
                self._planners.__getitem__,
            )
        text = json.dumps(report, indent=1, allow_nan=False) + "\n"
        write_text(self.out / "evaluation.json", text, overwrite=True)


def _show(report: dict[str, Any]) -> None:
    rates = report["rates"]
    console.print_table(
        f"{report['scenario_set']}: {rates[0]['scenarios']} scenarios, % and 95 % Wilson intervals",
        [
            "planner",
            "intention",
            "input",
            "success",
            "collision",
            "safe driving",
            "swept collision",
            "no plan because",
        ],
        [
            [
                row["planner"],
                row["intention"],
                row["input"].replace("_", " "),
                *(
                    percent
                    for name in (
                        "success_rate",
                        "collision_rate",
                        "safe_driving_rate",
                        "swept_collision_rate",
                    )
                    for percent in [console.percent(row[name], row[f"{name}_interval"])]
                ),
                ", ".join(f"{name} {count}" for name, count in row["failures"].items()),
            ]
            for row in rates
        ],
    )
    if report["differences"]:
        console.print_table(
            "detections minus ground truth, percentage points, 95 % paired bootstrap intervals",
            [
                "planner",
                "intention",
                "safe driving",
                "became unsafe",
                "became safe",
                "McNemar p, corrected",
            ],
            [
                [
                    row["planner"],
                    row["intention"],
                    console.percent(row["safe_driving_rate"], row["safe_driving_rate_interval"]),
                    str(row["became_unsafe"]),
                    str(row["became_safe"]),
                    "–" if row["mcnemar_p_holm"] is None else f"{row['mcnemar_p_holm']:.2g}",
                ]
                for row in report["differences"]
            ],
        )
    for row in report.get("sweep", []):
        console.say(
            f"score >= {row['score_threshold']:.3g}, {row['intention']}: safe driving"
            f" {console.percent(row['safe_driving_rate'])} %"
        )
