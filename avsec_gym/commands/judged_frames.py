"""What `avsec validate` reports of the frames that it judges: line by line, and in sum."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from avsec_gym import console
from avsec_gym.commands.left_out import say_kept, say_left_out
from avsec_gym.commands.recorded_stamps import frame_stamps
from avsec_gym.errors import AvsecError, DataError
from avsec_gym.json_schemas import with_schema
from avsec_gym.storage.text_files import write_text

if TYPE_CHECKING:
    from avsec_gym.attacks.optical_attack import OpticalAttack
    from avsec_gym.frame import SensorFrame
    from avsec_gym.validation.recordings import RecordedFrame
    from avsec_gym.validation.validation_folder import ValidationFolder
    from avsec_gym.validation.validator import Validator

_RATES = {
    "alarms as recorded (false, if unattacked)": "alarms_as_recorded",
    "attacks detected": "attacks_detected",
    "attacked sensors named exactly": "attacks_named",
}


@dataclass(frozen=True)
class JudgedFrames:
    """Frames of a recording, a validator, and the folder that keeps its results.

    Args:
        frames: The frames, one or more.
        validator: The validator that judges the frames.
        folder: The folder of this question; what it knows already is not asked again, unless the
            frame has changed since.
        attack: The attack on each of the frames; None: they are judged as they were recorded.
        seed: Seed of the attack.
        locate: Whether damage is looked for in the sensors that are named.
        as_json: Whether JSON lines are printed instead of words.
        origin: What the validator was fitted on, in words, which stands in every output.
        draw_all: Whether frames without an alarm have a picture, too.
        record: Whether each picture has a recording for the Rerun viewer beside it.
    """

    frames: Sequence[RecordedFrame]
    validator: Validator
    folder: ValidationFolder
    attack: OpticalAttack | None
    seed: int
    locate: bool
    as_json: bool
    origin: str = ""
    draw_all: bool = False
    record: bool = False

    def judge(self, left_out: dict[str, str]) -> None:
        """Judge each frame, and report its result at once.

        Args:
            left_out: The dictionary that gets the reason for each frame that cannot be judged, by
                its id.

        Raises:
            AvsecError: None could be judged; why the first could not.
        """
        refused: list[AvsecError] = []
        known = self._rows
        say_kept(len(known), len(self.frames), "frames")
        for row in known.values():
            self._tell(row)
        missing = [(n, frame) for n, frame in enumerate(self.frames) if frame.id not in known]
        with console.progress("validating") as shown:
            for done, (number, recorded) in enumerate(missing, start=1):
                try:
                    frame = recorded.read(self.validator.system)
                except DataError as error:
                    left_out[recorded.id] = str(error)
                else:
                    if problem := self._judge_one(recorded.id, frame, number):
                        refused.append(problem)
                        left_out[recorded.id] = str(problem)
                shown(done, len(missing))
        if refused and not self._rows:
            raise refused[0]

    def _judge_one(self, id: str, frame: SensorFrame, number: int) -> AvsecError | None:
        """Attack a frame if asked to, validate it, keep and print the result.

        Returns:
            Why the validator refuses the frame: another rig, or images of two sizes.  Of this
            frame, perhaps not of others.
        """
        from avsec_gym.attacks.optical_attack import TamperedFrame
        from avsec_gym.drawing.validation_picture import save_validation_picture
        from avsec_gym.validation.repair.damage import located_damage
        from avsec_gym.validation.validation_folder import row_of

        seed = self.seed, number
        tampered = self.attack.attack(frame, seed) if self.attack else TamperedFrame(frame)
        begun = time.perf_counter()
        try:
            validation = self.validator.validate(tampered.frame)
        except AvsecError as error:
            return error
        judged_at = time.perf_counter()
        damage = located_damage(validation) if self.locate else {}
        seconds = judged_at - begun, time.perf_counter() - judged_at
        row = row_of(id, validation, tampered.attacked, damage, seconds)
        row |= {"fitted_on": self.origin, "recorded": self._stamps[id]}
        # The picture first: a row that is kept has its picture, and not that of an earlier one.
        pictures = {
            is_alarm: self.folder.out / kind / f"{id.replace('/', '_')}.png"
            for is_alarm, kind in ((True, "alarms"), (False, "no_alarms"))
        }
        for picture in pictures.values():
            picture.unlink(missing_ok=True)
            picture.with_suffix(".rrd").unlink(missing_ok=True)
        if validation.alarm or self.draw_all:
            picture = pictures[validation.alarm]
            save_validation_picture(validation, picture, damage, self.origin)
            if self.record:
                from avsec_gym.drawing.rerun_alarm import write_alarm_recording

                path = picture.with_suffix(".rrd")
                write_alarm_recording(validation, path, damage, self.origin)
        self.folder.add(row)
        self._tell(row)
        return None

    def report(self, left_out: Mapping[str, str]) -> int:
        """Sum up, in words or JSON and in ``summary.json``; the exit code.

        Args:
            left_out: The reasons why frames could not be judged, by their ids.
        """
        from avsec_gym.validation.validation_folder import summary

        say_left_out(left_out, "frames")
        drives = {frame.id: frame.drive for frame in self.frames if frame.drive is not None}
        found, out = summary(self._rows, drives), self.folder.out
        found |= {"left_out": len(left_out), "fitted_on": self.origin}
        document = with_schema("validate.summary", found)
        write_text(out / "summary.json", json.dumps(document, indent=1) + "\n", overwrite=True)
        if self.as_json:
            console.print_json_line("validate.summary", {"summary": found})
        else:
            lines = [
                [
                    title,
                    f"{one['count']} of {one['of']}",
                    console.percent(one["rate"], one["interval"]),
                ]
                for title, key in _RATES.items()
                if (one := found[key])["of"]
            ]
            console.print_table(
                f"{found['frames']} frames, {found['alarms']} alarms"
                f"{f'; {self.origin}' if self.origin else ''}; {out}",
                ["", "frames", "% (95 %)"],
                lines,
            )
        return console.DONE_IN_PART if left_out else console.DONE

    @cached_property
    def _stamps(self) -> dict[str, str]:
        return frame_stamps(self.frames, self.validator.system)

    @property
    def _rows(self) -> dict[str, dict[str, Any]]:
        """Of these frames as they are now; the folder may have others."""
        rows = self.folder.rows
        return {
            id: rows[id]
            for id, stamp in self._stamps.items()
            if id in rows and rows[id].get("recorded") == stamp
        }

    def _tell(self, row: Mapping[str, Any]) -> None:
        from avsec_gym.commands.validation_line import validation_line

        if self.as_json:
            console.print_json_line("validate.frame", row)
        else:
            console.print_line(validation_line(row))
