"""Tables of what a validator before the detector is worth, and how soon it raises an alarm."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.drawing.page_table import UNKNOWN, Table, TableCell, figure, name
from avsec_gym.drawing.validation_picture import named
from avsec_gym.experiments.chapter3.defence.defended_episodes import NO_ATTACK
from avsec_gym.experiments.chapter3.defence.oracles import LIDAR_ORACLE, STEREO_ORACLE
from avsec_gym.experiments.chapter3.defence.rates import (
    ANY_ATTACK,
    AlarmRow,
    DefenceRow,
    DefenceSummary,
)
from avsec_gym.experiments.chapter3.identification.tables import INTERVALS
from avsec_gym.experiments.chapter5.attack_names import detector_name
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.sensor_system import LIDAR

_ORACLES = {STEREO_ORACLE: "oracle of images", LIDAR_ORACLE: "oracle of scans"}
_SHARES = ("avoided", "avoided_of_attack", "caused", "regained", "given_up", "stopped")


def tables_of_defence(summary: DefenceSummary) -> list[Table]:
    """Collisions avoided against false stops, and frames to alarm.

    Args:
        summary: The rows of a run.
    """
    return [_worth_table(summary.worth), _alarm_table(summary.alarms)]


def _worth_table(rows: Sequence[DefenceRow]) -> Table:
    lines, undefended = [], {}
    for row in rows:
        case, rates = (row.detector, row.attack), row.rates
        if row.worth is None:
            shares = rates.collisions / rates.scenarios, rates.safe_driving_rate
            undefended[case] = [figure(share, scale=100) for share in shares]
            continue
        words = defended_detector(row.detector), attacked_sensors(row.attack), row.response
        changes = [_share(getattr(row.worth, share)) for share in _SHARES]
        safe = figure(rates.safe_driving_rate, scale=100)
        lines.append([*map(name, words), *undefended[case], safe, *changes])
    return Table(
        "What a defence is worth: collisions avoided and safety regained, against episodes given up"
        " and false stops, %",
        [
            *("detector", "attacked", "response"),
            *("collide undefended", "safe undefended", "safe defended", "avoided"),
            *("avoided of the attack’s", "caused", "safe again", "given up", "stopped in"),
        ],
        lines,
        "A case is a frame, an intention and an attack. Safe: reach the goal without a collision."
        " Avoided: do not collide any more, of the cases that did; of the attack’s: of those that"
        " did only under attack. Caused: collide now, of those that did not. Safe again: of those"
        " that the attack made unsafe, such as by a blocked road. Given up: were safe and reach no"
        " goal any more. Stopped in: frames; false stops where nothing is attacked."
        f" {INTERVALS}",
        names=3,
    )


def _alarm_table(rows: Sequence[AlarmRow]) -> Table:
    lines = []
    for row in rows:
        shares = [_share(row.alarms), _share(row.named_exactly)]
        lines.append([name(attacked_sensors(row.attack)), *shares, *_first_alarms(row)])
    return Table(
        "How soon an attack is detected",
        ["attacked", "alarms, %", "named exactly, %", "at once, %", "later", "never, %"],
        lines,
        "Alarms: of frames; named exactly: the attacked sensors and no others. At once: of drives,"
        " an alarm in the first frame of the attack; later: how many of them after how many"
        " frames. A validator knows no earlier frame, so that it waits for what the scene hides.",
    )


def _first_alarms(row: AlarmRow) -> list[TableCell]:
    """At once, later and never."""
    waited = row.frames_to_alarm
    if waited is None:
        return [TableCell(UNKNOWN)] * 3
    counts = [frames for frames, count in waited.items() for _ in range(count)]
    later = [f"{n} after {frames}" for frames, n in waited.items() if frames not in ("0", "never")]
    drives = [str(number) for number in range(len(counts))]
    at_once, never = (
        share_of([frames == which for frames in counts], drives) for which in ("0", "never")
    )
    return [_share(at_once), TableCell(", ".join(later) or UNKNOWN), _share(never)]


def defended_detector(detector: str) -> str:
    """The name of a detector of the experiment."""
    return _ORACLES.get(detector) or detector_name(detector)


def attacked_sensors(attack: str) -> str:
    """The attacked sensors of the experiment, in words."""
    if attack in (NO_ATTACK, ANY_ATTACK):
        return {NO_ATTACK: "nothing", ANY_ATTACK: "any of these"}[attack]
    sensors = (named(sensor if sensor == LIDAR else int(sensor)) for sensor in attack.split("+"))
    return " and ".join(sensors)


def _share(hits: Share) -> TableCell:
    return figure(hits.rate, hits.interval, scale=100)
