"""What a defence is worth, as tables: collisions avoided, false stops, frames to alarm."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from avsec_gym.emergency_stop import STOPPED
from avsec_gym.experiments.chapter3.defence.defended_drives import NO_ATTACK, UNDEFENDED
from avsec_gym.experiments.chapter3.shares import drive_of, share_of
from avsec_gym.metrics.paired import paired_differences
from avsec_gym.metrics.safety import SafetyRates, SafetyRecord
from avsec_gym.runs.results import Results
from avsec_gym.validation.response import Response

Row = dict[str, Any]
Drive = tuple[str, str]
"""Scenario and intention."""
ANY_ATTACK = "any"
"""All attacks together, each of them as often as the others."""


def defence_summary(results: Results) -> dict[str, list[Row]] | None:
    """`defence_rows` as ``worth`` and `alarm_rows` as ``alarms``; None if nobody was defended."""
    worth = [row for row in defence_rows(results) if row["scenarios"]]
    return {"worth": worth, "alarms": alarm_rows(results)} if worth else None


def is_of_defence(setting: str) -> bool:
    """Whether it names a detector, an attack and a response, or `UNDEFENDED`."""
    words = setting.rsplit(" ", 2)
    return len(words) == 3 and words[2] in (UNDEFENDED, *Response)


def defence_rows(results: Results) -> list[Row]:
    """For each detector, attack (`NO_ATTACK` first, `ANY_ATTACK` last) and response: its worth.

    Returns:
        Rows with ``detector``, ``attack``, ``response`` (`UNDEFENDED` first) and the rates as of
        `SafetyRates.to_json`, where a stop reaches no goal.  Of a defence also shares (`share_of`,
        by the drive that was recorded), of drives

        ``avoided``  that do not collide any more, of those that did;
        ``avoided_of_attack`` the same, of those that did not collide before the attack;
        ``caused``   that collide now, of those that did not;
        ``regained`` that are safe again, of those that the attack made unsafe;
        ``given_up`` that were safe and reach no goal any more, of those that were safe;

        of moments ``stopped`` in, which are false stops where nobody attacks; and ``paired``, the
        differences of the rates to the undefended car (`paired_differences`).
    """
    found: dict[tuple[str, str], dict[str, list[SafetyRecord]]] = {}
    for setting, _ in results.settings():
        if is_of_defence(setting):
            detector, attack, response = setting.rsplit(" ", 2)
            records = results.records(setting=setting)
            found.setdefault((detector, attack), {})[response] = records
    rows = []
    for detector in sorted({detector for detector, _ in found}):
        own = {attack: there for (one, attack), there in found.items() if one == detector}
        attacks = sorted(attack for attack in own if attack != NO_ATTACK)
        clean = {_drive(one): one for one in own.get(NO_ATTACK, {}).get(UNDEFENDED, ())}
        cases = {attack: [attack] for attack in (NO_ATTACK, *attacks) if attack in own}
        for name, together in {**cases, ANY_ATTACK: attacks}.items():
            for response in (UNDEFENDED, *Response):
                pairs = [
                    pair
                    for one in together
                    for pair in zip(own[one][UNDEFENDED], own[one][response], strict=True)
                ]
                rates = SafetyRates.of(now for _, now in pairs).to_json()
                worth = {} if response == UNDEFENDED else _worth(pairs, clean)
                told = {"detector": detector, "attack": name, "response": str(response)}
                rows.append({**told, **rates, **worth})
    return rows


def alarm_rows(results: Results) -> list[Row]:
    """For each attack (`NO_ATTACK` first): is it noticed, and how soon?

    Returns:
        Rows with ``attack``; ``alarms``, the share of moments; ``named_exactly``, the share of
        moments in which the attacked sensors were named and no others, with an alarm for an attack
        and without one for none; and of an attack
        ``frames_to_alarm``: of so many drives, the first frame with an alarm, counted from the one
        that the attack began in, 0 at once; ``never``: in none.
    """
    alarms: dict[str, dict[str, bool]] = {}
    for row in results.measurements(name="alarm"):
        alarms.setdefault(row["setting"], {})[row["scenario"]] = bool(row["value"])
    named: dict[str, dict[str, set[str]]] = {}
    for row in results.measurements():
        sensor = row["name"].removeprefix("named ")
        if row["value"] == 1 and sensor != row["name"]:
            named.setdefault(row["setting"], {}).setdefault(row["scenario"], set()).add(sensor)
    rows = []
    for attack in sorted(alarms, key=lambda name: (name != NO_ATTACK, name.count("+"), name)):
        true = set() if attack == NO_ATTACK else set(attack.split("+"))
        said = named.get(attack, {})
        rows.append(
            {
                "attack": attack,
                "alarms": _share(alarms[attack].items()),
                "named_exactly": _share(
                    (id, alarm == bool(true) and said.get(id, set()) == true)
                    for id, alarm in alarms[attack].items()
                ),
            }
        )
        if attack != NO_ATTACK:
            rows[-1]["frames_to_alarm"] = frames_to_alarm(alarms[attack])
    return rows


def frames_to_alarm(alarms: dict[str, bool]) -> dict[str, int]:
    """Of each drive, which frame brought the first alarm; see `alarm_rows`.

    Args:
        alarms: By moment, of an attack that begins with each drive's first frame.

    Example:
        >>> frames_to_alarm({"a/0": False, "a/1": True, "b/0": True, "b/1": True, "c/0": False})
        {'0': 1, '1': 1, 'never': 1}
    """
    drives: dict[str, list[bool]] = {}
    for moment in sorted(alarms):
        drives.setdefault(drive_of(moment), []).append(alarms[moment])
    firsts = Counter(said.index(True) for said in drives.values() if any(said))
    counted = {str(frame): firsts[frame] for frame in sorted(firsts)}
    return {**counted, "never": len(drives) - sum(firsts.values())}


def _share(hits: Iterable[tuple[str, bool]]) -> dict[str, Any]:
    """Of moments' ids, and whether it is a hit."""
    cases = list(hits)
    return share_of([hit for _, hit in cases], [drive_of(id) for id, _ in cases])


def _worth(
    pairs: Sequence[tuple[SafetyRecord, SafetyRecord]], clean: Mapping[Drive, SafetyRecord]
) -> Row:
    """See `defence_rows`.

    Args:
        pairs: Of drives without a defence and with one.
        clean: The same drives without attack and defence.
    """
    were = [(now.scenario, was, now) for was, now in pairs]
    collided = [(id, now) for id, was, now in were if was.collision]
    before = {drive: record.collision for drive, record in clean.items()}
    safe = {drive: record.safe for drive, record in clean.items()}
    # A moment is stopped in for every intention, or for none.
    moments = [(id, now) for id, _, now in were if now.intention == pairs[0][1].intention]
    return {
        "avoided": _share((id, not now.collision) for id, now in collided),
        "avoided_of_attack": _share(
            (id, not now.collision) for id, now in collided if before.get(_drive(now)) is False
        ),
        "caused": _share((id, now.collision) for id, was, now in were if not was.collision),
        "regained": _share(
            (id, now.safe) for id, was, now in were if not was.safe and safe.get(_drive(now))
        ),
        "given_up": _share((id, not now.planned) for id, was, now in were if was.safe),
        "stopped": _share((id, now.reason == STOPPED) for id, now in moments),
        "paired": paired_differences([was for was, _ in pairs], [now for _, now in pairs]),
    }


def _drive(record: SafetyRecord) -> Drive:
    return record.scenario, record.intention
