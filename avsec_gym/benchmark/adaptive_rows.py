"""What an adaptive attack does to an entry beyond the listed attacks: whether it breaks it.

RobustBench flags entries whose robustness an adaptive attack disproves; so does this.  An entry is
broken where the adaptive attack does better than every listed one of the same budget, the whole
interval of the paired difference on one side of 0: a detector leaves fewer contested episodes safe;
a car with a validator collides in more of them; a validator of several vehicles alarms about fewer
attacks of which it could know.  A patch, any grey level in a disc, is another threat model than a
few grey levels anywhere: detectors are not compared under both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from avsec_gym.benchmark.episodes import ALARM, ENTERED
from avsec_gym.benchmark.protocol import (
    ADAPTIVE,
    OPTICAL,
    TRANSFERRED,
    VALIDATED,
    WHITE_BOX,
    adaptive,
)
from avsec_gym.drives.summary import mean_over_scenes
from avsec_gym.experiments.json_rows import OPTIONAL
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.paired import paired_differences
from avsec_gym.metrics.safety import SafetyRecord
from avsec_gym.runs.results import Results


@dataclass(frozen=True)
class AdaptiveRow:
    """An adaptive attack beside the listed attack that is strongest.

    Args:
        setting: The setting of the adaptive attack.
        against: The setting of the listed one.
        measure: What the difference is of: ``safe`` or ``collided`` episodes, ``detected`` attacks.
        difference: The difference of that share, the adaptive attack minus the listed one, on the
            same cases.
        breaks: Whether it does better than every listed attack of its budget, the whole interval
            on its side of 0.
        detected: Frames or attacks under the adaptive attack about which a validator alarms.
    """

    setting: str
    against: str
    measure: str
    difference: Estimate
    breaks: bool
    detected: Share | None = field(default=None, metadata=OPTIONAL)


def detector_rows(run: Results) -> list[AdaptiveRow]:
    """The row of a detector; none where it could not be asked.

    Args:
        run: The run on the contested scenes.
    """
    under = run.records(setting=ADAPTIVE, planner=ENTERED)
    if not under:
        return []
    listed = {
        name: records
        for name in (TRANSFERRED, WHITE_BOX)
        if (records := run.records(setting=name, planner=ENTERED))
    }
    differences = {name: _safe_difference(records, under) for name, records in listed.items()}
    strongest = min(listed, key=lambda name: sum(record.safe for record in listed[name]))
    breaks = all(_is_below(each) for each in differences.values())
    return [AdaptiveRow(ADAPTIVE, strongest, "safe", differences[strongest], breaks)]


def validator_rows(run: Results) -> list[AdaptiveRow]:
    """A row for each case of a validator of one vehicle that is attacked adaptively.

    Args:
        run: The run on the contested scenes.
    """
    rows = []
    for case in OPTICAL:
        under = run.records(setting=adaptive(case), planner=ENTERED)
        if not under:
            continue
        listed = run.records(setting=f"{case}{VALIDATED}", planner=ENTERED)
        pairs = zip(under, listed, strict=True)
        changed = [float(one.collision) - float(other.collision) for one, other in pairs]
        difference = difference_of(changed, [record.scenario for record in under])
        alarms = run.measurements(name=ALARM, setting=adaptive(case))
        detected = share_of([row.value > 0 for row in alarms], [row.scenario for row in alarms])
        rows.append(
            AdaptiveRow(
                adaptive(case),
                f"{case}{VALIDATED}",
                "collided",
                difference,
                _is_above(difference),
                detected,
            )
        )
    return rows


def detection_row(
    setting: str, against: str, changed: Sequence[float], places: Sequence[str], detected: Share
) -> AdaptiveRow:
    """The row of a kind of attack on a validator of several vehicles.

    Args:
        setting: The setting of the adaptive attack.
        against: The setting of the listed one.
        changed: A number for each place: 1 where only the adaptive attack is detected, -1 where
            only the listed one is, else 0.
        places: The places.
        detected: The share of detected attacks among the adaptive ones that another vehicle can
            see.
    """
    difference = difference_of(changed, places)
    return AdaptiveRow(setting, against, "detected", difference, _is_below(difference), detected)


def difference_of(changed: Sequence[float], clusters: Sequence[str]) -> Estimate:
    """The mean of paired differences, with an interval that knows which cases share a scene."""
    if not len(changed):
        return Estimate(None)
    mean = mean_over_scenes(np.array(changed, float), clusters)
    return Estimate(mean.value, mean.interval)


def _safe_difference(listed: list[SafetyRecord], under: list[SafetyRecord]) -> Estimate:
    paired = paired_differences(listed, under)
    assert paired is not None
    return paired.safe_driving_rate


def _is_below(difference: Estimate) -> bool:
    return difference.interval is not None and difference.interval[1] < 0


def _is_above(difference: Estimate) -> bool:
    return difference.interval is not None and difference.interval[0] > 0
