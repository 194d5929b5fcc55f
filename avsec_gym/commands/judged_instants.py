"""What `avsec connected` reports of the instants that it judges: line by line, and in sum."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from avsec_gym import console
from avsec_gym.commands.attacked_drives import AttackedDrives
from avsec_gym.commands.instant_rows import attack_row, drive_of, registered_row, sent_bytes
from avsec_gym.commands.instant_summary import summary
from avsec_gym.commands.judged_sequences import JudgedSequences, drive_line
from avsec_gym.commands.left_out import say_kept, say_left_out
from avsec_gym.commands.recorded_stamps import instant_stamp
from avsec_gym.json_schemas import with_schema
from avsec_gym.storage.text_files import write_text

if TYPE_CHECKING:
    from avsec_gym.validation.connected.attacks.attacked_instant import InstantAttack
    from avsec_gym.validation.connected.fit import ConnectedFit
    from avsec_gym.validation.connected.recordings import RecordedInstant
    from avsec_gym.validation.connected.sources import ConnectedSource
    from avsec_gym.validation.connected.validator import ConnectedValidator
    from avsec_gym.validation.validation_folder import ValidationFolder


_RATES = {
    "alarms": "alarms",
    "attacks_detected": "attacks detected, of all",
    "attacks_detected_decidable": "attacks detected, of those that some other vehicle sees",
    "victims_named": "victims named, of attacks detected",
    "wrongly_named": "honest vehicles named, of all instants",
}


_SUMS = {
    "windows": "windows of successive instants that alarm",
    "drives": "drives with such a window",
}


@dataclass(frozen=True)
class JudgedInstants:
    """Instants, a validator, and the folder that keeps its results.

    Args:
        source: The instants.
        validator: The validator that judges them.
        fit: What its constants were fitted on.
        folder: The folder of this question; what it knows already is not asked again, unless the
            instant has changed since.
        attack: The attack on each of the instants; None: they are judged as they were recorded.
        seed: Seed of the attack.
        pictures: Most pictures of alarms.
        as_json: Whether JSON lines are printed instead of words.
        recording: A file for the Rerun viewer, of the first instant that alarms, or of the first
            one where none does; None: none is written.
    """

    source: ConnectedSource
    validator: ConnectedValidator
    fit: ConnectedFit
    folder: ValidationFolder
    attack: InstantAttack | None
    seed: int
    pictures: int
    as_json: bool
    recording: Path | None = None

    def judge(self, left_out: dict[str, str]) -> dict[str, str]:
        """Judge each instant, and report its result at once.

        Args:
            left_out: The dictionary that gets the reason for each drive and instant that cannot be
                read, by name.

        Returns:
            The drive of each instant by the instant's id, in the order of the instants.

        Raises:
            ConfigurationError: The constants were fitted on another LiDAR.
            DataError: A file of the data is missing or broken.
        """
        known, total = self.folder.rows, len(self.source.names)
        alarm_recorded, drives, kept = False, dict[str, str](), 0
        attacks = AttackedDrives(self.attack, self.seed) if self.attack else None
        with console.progress("comparing vehicles") as shown:
            for number, instant in enumerate(self.source.read(left_out)):
                drive, stamp = drive_of(instant), instant_stamp(instant)
                if attacks is not None:
                    attacks.show(instant, number, drive)
                if known.get(instant.id, {}).get("recorded") == stamp:
                    kept += 1
                else:
                    drawn = sum(known[id]["alarm"] for id in drives)
                    row = self._judge_one(instant, number, attacks, drawn < self.pictures)
                    self.folder.add({**row, "recorded": stamp})
                row, drives[instant.id] = known[instant.id], drive
                self._tell(row)
                if self.recording and (number == 0 or row["alarm"] > alarm_recorded):
                    self._record(instant, number, attacks, self.recording)
                    alarm_recorded = row["alarm"]
                if total:
                    shown(number + 1, total)
        say_kept(kept, len(drives), "instants")
        return drives

    def _record(
        self, recorded: RecordedInstant, number: int, attacks: AttackedDrives | None, path: Path
    ) -> None:
        """Write an instant for the Rerun viewer; it is judged again, as a row has no scans."""
        from avsec_gym.drawing.rerun_instant import write_instant_recording

        attacked = None if attacks is None else attacks.attacked(recorded, number)
        scans = recorded.scans if attacked is None else attacked.instant.scans
        write_instant_recording(scans, path, self.validator.validate(scans, id=recorded.id))

    def _judge_one(
        self,
        recorded: RecordedInstant,
        number: int,
        attacks: AttackedDrives | None,
        draws: bool,
    ) -> dict[str, Any]:
        """The row of an instant; its alarm is drawn where `draws`."""
        attacked = None if attacks is None else attacks.attacked(recorded, number)
        instant = recorded if attacked is None else attacked.instant
        # A rig is recognised by what was recorded, not by what an attacker made of it.
        self.fit.check(recorded.scans)
        result = self.validator.validate(instant.scans, id=instant.id)
        # The picture first: a row that is kept has its picture, and not that of an earlier one.
        picture = self.folder.out / "alarms" / f"{instant.id.replace('/', '_')}.png"
        picture.unlink(missing_ok=True)
        if result.alarm and draws:
            from avsec_gym.drawing.connected_picture import save_connected_picture

            save_connected_picture(
                picture,
                result,
                instant.scans,
                self.validator.constants.margins,
                self.fit.origin,
            )
        return {
            **result.to_json(),
            "attack": None if attacked is None else attack_row(attacked, result),
            "attack_possible": self.attack is None or attacked is not None,
            "vehicles": len(instant.scans),
            "drive": drive_of(recorded),
            **registered_row(recorded),
        }

    def add_up(self, judged: JudgedSequences, drives: Mapping[str, str]) -> dict[str, Any]:
        """Report each drive by what adds up over its instants.

        Args:
            judged: The test over windows of instants.
            drives: The drive of each instant, as of `judge`.

        Returns:
            The part of the summary that is about drives.
        """
        rows = judged.rows([self.folder.rows[id] for id in drives], drives)
        for row in rows:
            if self.as_json:
                console.print_json_line("connected.drive", asdict(row))
            else:
                console.print_line(drive_line(row))
        return judged.summary(rows)

    def report(
        self,
        drives: Mapping[str, str],
        left_out: Mapping[str, str],
        sums: Mapping[str, Any] | None = None,
    ) -> int:
        """Sum up, in words or JSON and in ``summary.json``; the exit code.

        Args:
            drives: The drive of each instant, as of `judge`; the folder may have other instants.
            left_out: The reasons why drives and instants could not be read, by name.
            sums: What added up over drives, as of `add_up`.

        Raises:
            DataError: No instant was judged.
        """
        say_left_out(left_out, "drives and instants")
        found = summary([self.folder.rows[id] for id in drives])
        found |= {"method": self.validator.method, "fitted_on": self.fit.origin}
        found |= {"left_out": len(left_out)}
        if sums is not None:
            found["sequence"] = dict(sums)
        document = with_schema("connected.summary", found)
        path = self.folder.out / "summary.json"
        write_text(path, json.dumps(document, indent=1) + "\n", overwrite=True)
        if self.as_json:
            console.print_json_line("connected.summary", {"summary": found})
        else:
            rows = [
                [title, f"{found[key]['hits']} of {found[key]['cases']}", _percent(found[key])]
                for key, title in _RATES.items()
            ]
            for key, title in _SUMS.items():
                if sums is not None:
                    share = sums[key]
                    counts = f"{share['hits']} of {share['cases']}"
                    rows.append([title, counts, _percent(share)])
            console.print_table("instants", ["", "", "% (95 % interval)"], rows)
            console.say(
                f"avsec: a vehicle sent {found['bytes_largest']} bytes at most; an instant took "
                f"{found['seconds']:.2f} s, of which proposals {found['seconds_of']['propose']:.2f}"
                f" (medians); {self.folder.out} holds lines and pictures"
            )
        return console.DONE_IN_PART if left_out else console.DONE

    def _tell(self, row: dict[str, Any]) -> None:
        if self.as_json:
            console.print_json_line("connected.instant", row)
            return
        text = f"{row['id']}: {_status(row)}"
        if row["attack"] is not None:
            text += f"; the attack was a {row['attack']['kind']} on vehicle "
            text += f"{row['attack']['victim']}, {row['attack']['outcome']}"
        text += f"; {row['decidable']} of {row['regions']} regions seen twice,"
        text += f" {max(sent_bytes(row))} bytes a vehicle at most"
        if fits := [each for each in row.get("registrations", ()) if each is not None]:
            text += "; registered to "
            text += ", ".join(f"{each['residual']:.3f} m" for each in fits)
            text += f", {min(each['overlap'] for each in fits):.0%} overlap or more"
        console.print_line(text)


def _percent(rate: dict[str, Any]) -> str:
    return console.percent(rate["rate"], rate["interval"])


def _status(row: dict[str, Any]) -> str:
    if not row["alarm"]:
        return "no alarm"
    if row["accused"]:
        return f"ALARM, vehicle {', '.join(map(str, row['accused']))} is attacked"
    return "ALARM, cannot tell whose LiDAR"
