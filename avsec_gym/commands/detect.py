"""`avsec detect`: a detector's results as a KITTI folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from avsec_gym import console
from avsec_gym.commands.named_part import named_part
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.registry import Kind, check, kind_of, names

_REMARKS = 10
"""So many frames that were left out are reported one by one."""


@dataclass(frozen=True)
class Detect:
    """Write what a detector sees as KITTI result files, for `avsec ap` and `avsec evaluate`.

    A run that was stopped goes on where it was.
    """

    kitti: Path
    """A folder in KITTI's object layout, such as `avsec world make` writes."""
    detector: str
    """Its name, such as dsgn; or JSON with arguments, '{"name": "dsgn", "weights": "my.st"}'.

    Those of single images (faster_rcnn, yolo) find 2D boxes for `avsec ap` alone: no car can drive
    by them.
    """
    out: Path
    """Folder of the results: new, empty, or with results of the same detector on the same data."""
    split: str | None = None
    """The frames of ImageSets/SPLIT.txt, such as val.  Default: all that have a calibration."""
    ids: tuple[str, ...] = ()
    """Frames, such as 000107 000274."""
    limit: int | None = None
    """Only the first frames."""
    attack: str | None = None
    """What tampers with the frames first: the name of an attack, one of a plug-in's too, or JSON
    with arguments, such as '{"name": "facula", "camera": 2}'.  Those on a detector need labels."""
    seed: int = 0
    """Seed of the attack."""
    camera: int | None = None
    """The camera whose image a detector of single images looks at. Default: 2."""
    workers: int = 1
    """Number of processes; each loads its own detector."""
    json: bool = False
    """Print a summary as JSON."""

    def run(self) -> int:
        """Do it; the exit code."""
        from avsec_gym.kitti.dataset import KittiObject
        from avsec_gym.perception.result_folder import write_result_folder

        # What can be refused before anything is read.
        for name in ("limit", "workers"):
            value = getattr(self, name)
            if value is not None and value < 1:
                raise ConfigurationError(f"--{name} is 1 or more, got {value}")
        if self.ids and self.split is not None:
            raise ConfigurationError("--ids and --split exclude each other")
        detector = self._asked()
        # The frames that are asked for, and their detections.
        data = KittiObject(self.kitti)
        having = () if self.split else ("calib",)
        ids = list(dict.fromkeys(self.ids)) or data.ids(self.split, having=having)
        if not ids:
            raise DataError("there is no frame.", path=self.kitti, remedy="Name another split.")
        with console.progress("detecting") as shown:
            outcome = write_result_folder(
                self.kitti,
                ids[: self.limit],
                detector,
                self.out,
                workers=self.workers,
                on_progress=shown,
            )
        # Report.
        for error in list(outcome.skipped.values())[:_REMARKS]:
            console.say(f"avsec: left out: {error}")
        if len(outcome.skipped) > _REMARKS:
            console.say(f"avsec: left out: {len(outcome.skipped) - _REMARKS} more frames")
        if self.json:
            console.print_json(
                "detect",
                {
                    "out": str(self.out),
                    "written": outcome.written,
                    "kept": outcome.kept,
                    "left_out": {id: str(error) for id, error in outcome.skipped.items()},
                },
            )
        else:
            console.say(
                f"{self.out}: {outcome.written} frames written, {outcome.kept} were there,"
                f" {len(outcome.skipped)} left out"
            )
        return console.DONE_IN_PART if outcome.skipped else console.DONE

    def _asked(self) -> Any:
        """What the registry takes: the detector, perhaps looking through an attack.

        Raises:
            ConfigurationError: The JSON is none, nothing has that name, or a camera is given to a
                detector of all images.
        """
        from avsec_gym.attacks.attacked_detector import attack_kind

        if self.attack is None:
            if self.seed:
                raise ConfigurationError("--seed belongs to --attack")
            return self._looking
        attack = named_part(self.attack, "--attack")
        check(attack_kind(attack), attack)  # Before any frame is looked for.
        return {"name": "attacked", "detector": self._looking, "attack": attack, "seed": self.seed}

    @property
    def _looking(self) -> Any:
        what = named_part(self.detector)
        if kind_of(what, (Kind.DETECTOR, Kind.IMAGE_DETECTOR)) == Kind.IMAGE_DETECTOR:
            return {
                "name": "single_image",
                "detector": what,
                "camera": 2 if self.camera is None else self.camera,
            }
        if self.camera is not None:
            raise ConfigurationError(
                f"--camera is for {', '.join(names(Kind.IMAGE_DETECTOR))}, not {self.detector}"
            )
        return what
