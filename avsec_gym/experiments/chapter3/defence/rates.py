"""What a defence is worth, as tables: collisions avoided, false stops, frames to alarm."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from avsec_gym.emergency_stop import STOPPED
from avsec_gym.experiments.chapter3.defence.defended_episodes import NO_ATTACK, UNDEFENDED
from avsec_gym.experiments.json_rows import FLAT, OPTIONAL
from avsec_gym.metrics.clustered_shares import Share, share_of
from avsec_gym.metrics.paired import PairedRates, paired_differences
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord
from avsec_gym.runs.results import Results
from avsec_gym.validation.recordings import drive_of
from avsec_gym.validation.response import Response

EpisodeKey = tuple[str, str]
"""Scenario and intention."""
ANY_ATTACK = "any"
"""All attacks together, each of them as often as the others."""


@dataclass(frozen=True)
class Worth:
    """What a defence changes, against the undefended car.

    Args:
        avoided: Episodes that do not collide any more, of those that did.
        avoided_of_attack: The same share of those that did not collide before the attack.
        caused: Episodes that collide now, of those that did not.
        regained: Episodes that are safe again, of those that the attack made unsafe.
        given_up: Episodes that reach no goal any more, of those that were safe.
        stopped: Frames that the car stops in, which are false stops without an attack.
        paired: Differences of the rates.
    """

    avoided: Share
    avoided_of_attack: Share
    caused: Share
    regained: Share
    given_up: Share
    stopped: Share
    paired: PairedRates | None


@dataclass(frozen=True)
class DefenceRow:
    """What becomes of episodes with one response to alarms.

    Args:
        detector: The detector that is planned on.
        attack: The attacked sensors, `NO_ATTACK` or `ANY_ATTACK`.
        response: What the car does at an alarm, or `UNDEFENDED`.
        rates: The rates of the episodes, where a stop reaches no goal.
        worth: What the defence changes; None: the car is undefended.
    """

    detector: str
    attack: str
    response: str
    rates: SafetyRates
    worth: Worth | None = field(metadata=FLAT)


@dataclass(frozen=True)
class AlarmRow:
    """Whether an attack is detected, and how soon.

    Args:
        attack: The attacked sensors, or `NO_ATTACK`.
        alarms: Frames with an alarm.
        named_exactly: Frames in which the attacked sensors were named and no others, with an alarm
            for an attack and without one for none.
        frames_to_alarm: The number of drives by the frame that brought the first alarm, see
            `frames_to_alarm`; None without an attack.
    """

    attack: str
    alarms: Share
    named_exactly: Share
    frames_to_alarm: Mapping[str, int] | None = field(default=None, metadata=OPTIONAL)


@dataclass(frozen=True)
class DefenceSummary:
    """The results of a run on a defence.

    Args:
        worth: The rows of `defence_rows`.
        alarms: The alarms of `alarm_rows`.
    """

    worth: Sequence[DefenceRow]
    alarms: Sequence[AlarmRow]


def defence_summary(results: Results) -> DefenceSummary | None:
    """All rows of a run; None if no car was defended."""
    worth = [row for row in defence_rows(results) if row.rates.scenarios]
    return DefenceSummary(worth, alarm_rows(results)) if worth else None


def is_of_defence(setting: str) -> bool:
    """Whether it names a detector, an attack and a response, or `UNDEFENDED`."""
    words = setting.rsplit(" ", 2)
    return len(words) == 3 and words[2] in (UNDEFENDED, *Response)


def defence_rows(results: Results) -> list[DefenceRow]:
    """The worth of the defence, for each detector, attack and response.

    Returns:
        Rows, `NO_ATTACK` first and `ANY_ATTACK` last, of each attack `UNDEFENDED` first. All
        intervals are of clusters: the drives that were recorded.
    """
    found: dict[tuple[str, str], dict[str, list[SafetyRecord]]] = {}
    for setting, _ in results.settings():
        if is_of_defence(setting):
            detector, attack, response = setting.rsplit(" ", 2)
            records = results.records(setting=setting)
            found.setdefault((detector, attack), {})[response] = records
    rows = []
    for detector in sorted({detector for detector, _ in found}):
        own = {attack: there for (of, attack), there in found.items() if of == detector}
        attacks = sorted(attack for attack in own if attack != NO_ATTACK)
        clean = {_key(record): record for record in own.get(NO_ATTACK, {}).get(UNDEFENDED, ())}
        cases = {attack: [attack] for attack in (NO_ATTACK, *attacks) if attack in own}
        for name, together in {**cases, ANY_ATTACK: attacks}.items():
            for response in (UNDEFENDED, *Response):
                pairs = [
                    pair
                    for case in together
                    for pair in zip(own[case][UNDEFENDED], own[case][response], strict=True)
                ]
                rates = SafetyRates.of((now for _, now in pairs), _drive)
                worth = None if response == UNDEFENDED else _worth(pairs, clean)
                rows.append(DefenceRow(detector, name, str(response), rates, worth))
    return rows


def alarm_rows(results: Results) -> list[AlarmRow]:
    """Whether each attack is detected, and how soon; `NO_ATTACK` first."""
    alarms: dict[str, dict[str, bool]] = {}
    for row in results.measurements(name="alarm"):
        alarms.setdefault(row.setting, {})[row.scenario] = row.value > 0
    named: dict[str, dict[str, set[str]]] = {}
    for row in results.measurements():
        sensor = row.name.removeprefix("named ")
        if row.value == 1 and sensor != row.name:
            named.setdefault(row.setting, {}).setdefault(row.scenario, set()).add(sensor)
    rows = []
    for attack in sorted(alarms, key=lambda name: (name != NO_ATTACK, name.count("+"), name)):
        true = set() if attack == NO_ATTACK else set(attack.split("+"))
        own = named.get(attack, {})
        exact = (
            (id, alarm == bool(true) and own.get(id, set()) == true)
            for id, alarm in alarms[attack].items()
        )
        waited = None if attack == NO_ATTACK else frames_to_alarm(alarms[attack])
        rows.append(AlarmRow(attack, _share(alarms[attack].items()), _share(exact), waited))
    return rows


def frames_to_alarm(alarms: dict[str, bool]) -> dict[str, int]:
    """The number of drives of which each frame brought the first alarm.

    Args:
        alarms: Whether there is one, by the frame's id; the attack begins with each drive's first
            frame.

    Returns:
        Counts of drives by the number of the frame, 0 at once; ``never``: by none.

    Example:
        >>> frames_to_alarm({"a/0": False, "a/1": True, "b/0": True, "b/1": True, "c/0": False})
        {'0': 1, '1': 1, 'never': 1}
    """
    drives: dict[str, list[bool]] = {}
    for id in sorted(alarms):
        drives.setdefault(drive_of(id), []).append(alarms[id])
    firsts = Counter(raised.index(True) for raised in drives.values() if any(raised))
    counted = {str(frame): firsts[frame] for frame in sorted(firsts)}
    return {**counted, "never": len(drives) - sum(firsts.values())}


def _share(hits: Iterable[tuple[str, bool]]) -> Share:
    """Of frames' ids, and whether it is a hit."""
    cases = list(hits)
    return share_of([hit for _, hit in cases], [drive_of(id) for id, _ in cases])


def _worth(
    pairs: Sequence[tuple[SafetyRecord, SafetyRecord]], clean: Mapping[EpisodeKey, SafetyRecord]
) -> Worth:
    """What a defence changes.

    Args:
        pairs: Records of episodes without a defence and with one.
        clean: Records of the same episodes without attack and defence.
    """
    were = [(now.scenario, was, now) for was, now in pairs]
    collided = [(id, now) for id, was, now in were if was.collision]
    before = {key: record.collision for key, record in clean.items()}
    safe = {key: record.safe for key, record in clean.items()}
    # A frame is stopped in for every intention, or for none.
    frames = [(id, now) for id, _, now in were if now.intention == pairs[0][1].intention]
    return Worth(
        avoided=_share((id, not now.collision) for id, now in collided),
        avoided_of_attack=_share(
            (id, not now.collision) for id, now in collided if before.get(_key(now)) is False
        ),
        caused=_share((id, now.collision) for id, was, now in were if not was.collision),
        regained=_share(
            (id, now.safe) for id, was, now in were if not was.safe and safe.get(_key(now))
        ),
        given_up=_share((id, not now.planned) for id, was, now in were if was.safe),
        stopped=_share((id, now.reason == STOPPED) for id, now in frames),
        paired=paired_differences(
            [was for was, _ in pairs], [now for _, now in pairs], cluster=_drive
        ),
    )


def _drive(record: SafetyRecord) -> str:
    return drive_of(record.scenario)


def _key(record: SafetyRecord) -> EpisodeKey:
    return record.scenario, record.intention
