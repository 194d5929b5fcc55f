"""Which episodes of a run are worth a picture: chosen by rule, not by eye."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product

from avsec_gym.experiments.chapter5.flips import Flip, flips
from avsec_gym.experiments.chapter5.ghost_positions import (
    in_corridor,
)
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.chapter5.seen import found_cars
from avsec_gym.experiments.chapter5.settings import (
    JOINT_PATCHES,
    PATCHES,
    PERTURBATIONS,
    TEXTURE_ATTACKED,
)
from avsec_gym.kitti.detections import above
from avsec_gym.metrics.ghosts import ghosts
from avsec_gym.scenario.intention import Intention

COLLAPSE = "the strongest perturbation hides most cars, and yet all three episodes stay safe"
PATCHED = "a patch makes the episode unsafe while every car that was found is still found"
OFTEN = "more attacks make this episode unsafe than any other"
TEXTURED = "the strongest perturbation makes most ghosts beside the lanes"
RULES = (
    "Chosen by rule, not by eye, for each detector in turn: the scene in which the strongest"
    " perturbation hides most cars although all three episodes stay safe; an episode that a patch"
    " makes unsafe while every car is still found; the scene with most ghosts beside the lanes,"
    " once more with the road’s texture beside the road; the episode that most attacks make unsafe."
    " Of equal ones the first is taken."
)


@dataclass(frozen=True)
class Telling:
    """An episode to be shown.

    Args:
        rule: Why it was chosen, such as `COLLAPSE`.
        scenario: The scene's id.
        intention: The driving intention.
        conditions: The conditions that it is shown under, the unattacked one first.
    """

    rule: str
    scenario: str
    intention: Intention
    conditions: tuple[Condition, ...]


def telling_scenes(outcomes: Outcomes, count: int, threshold: float = 0.3) -> list[Telling]:
    """The most telling episodes, each in a scene of its own.

    They are chosen by `RULES`; every rule gives its first before one gives its second.

    Args:
        outcomes: The outcomes of a run.
        count: The largest number of scenes.
        threshold: The least score of a detection that is planned on; others do not count.
    """
    if not outcomes.scenarios or not count:
        return []
    detectors = dict.fromkeys(condition.detector for condition in outcomes.conditions)
    seen = _Seen(outcomes, threshold)
    rules = (_collapses, _patched, _textured, _often)
    waiting = [rule(seen, detector) for rule, detector in product(rules, detectors)]
    chosen: list[Telling] = []
    while waiting and len(chosen) < count:
        for way in list(waiting):
            used = {telling.scenario for telling in chosen}
            found = next((telling for telling in way if telling.scenario not in used), None)
            if found is None:
                waiting.remove(way)
            elif len(chosen) < count:
                chosen.append(found)
    return chosen


class _Seen:
    """What was seen under a condition, asked for often."""

    def __init__(self, outcomes: Outcomes, threshold: float) -> None:
        self.outcomes = outcomes
        self._threshold = threshold
        self.found: Callable[[Condition, Intention | None], list[set[int]]] = cache(self._found)
        self.flips: Callable[[], list[Flip]] = cache(lambda: flips(outcomes))

    def strongest(self, detector: str, attacks: Sequence[str]) -> Condition | None:
        """The last of its conditions of certain attacks, in float."""
        own = [
            condition
            for condition in self.outcomes.conditions
            if condition.detector == detector
            and condition.attack in attacks
            and not condition.whole_levels
        ]
        return own[-1] if own and own[-1].unattacked in self.outcomes.conditions else None

    def beside(self, condition: Condition) -> list[int]:
        """Ghosts outside of the driven lanes, of each scenario."""
        seen = self.outcomes.detections(condition)
        counts = []
        for scenario, boxes in zip(self.outcomes.scenarios, seen, strict=True):
            sure = above(boxes, self._threshold)
            unreal = sure[ghosts(sure, self.outcomes.labels[scenario])]
            counts.append(int((~in_corridor(unreal)).sum()))
        return counts

    def _found(self, condition: Condition, intention: Intention | None) -> list[set[int]]:
        labels = (self.outcomes.labels[scenario] for scenario in self.outcomes.scenarios)
        seen = self.outcomes.detections(condition, intention)
        return [
            set(found_cars(above(boxes, self._threshold), truth).nonzero()[0].tolist())
            for boxes, truth in zip(seen, labels, strict=True)
        ]


def _collapses(seen: _Seen, detector: str) -> Iterator[Telling]:
    attacked = seen.strongest(detector, PERTURBATIONS)
    if attacked is None:
        return
    clean = attacked.unattacked
    pairs = zip(seen.found(clean, None), seen.found(attacked, None), strict=True)
    lost = [len(before - after) for before, after in pairs]
    unsafe = {
        record.scenario
        for condition in (clean, attacked)
        for record in seen.outcomes.records(condition)
        if not record.safe
    }
    for number, scenario in _most(lost, seen.outcomes.scenarios):
        if number and scenario not in unsafe:
            yield Telling(COLLAPSE, scenario, Intention.STRAIGHT, (clean, attacked))


def _patched(seen: _Seen, detector: str) -> Iterator[Telling]:
    patches = PATCHES + JOINT_PATCHES
    flipped = _flips_of(seen, detector, patches)
    place = {scenario: number for number, scenario in enumerate(seen.outcomes.scenarios)}
    for (scenario, intention), rows in sorted(flipped.items(), key=_often_first):
        for row in sorted(rows, key=lambda row: patches.index(row.condition.attack)):
            attacked = Condition(detector, row.condition.attack)
            way = intention if None not in seen.outcomes.looks(attacked) else None
            before = seen.found(attacked.unattacked, None)[place[scenario]]
            if before and before <= seen.found(attacked, way)[place[scenario]]:
                yield Telling(PATCHED, scenario, intention, (attacked.unattacked, attacked))
                break


def _often(seen: _Seen, detector: str) -> Iterator[Telling]:
    attacks = PERTURBATIONS + PATCHES + JOINT_PATCHES
    for (scenario, intention), rows in sorted(
        _flips_of(seen, detector, attacks).items(), key=_often_first
    ):
        row = rows[-1]
        attacked = Condition(detector, row.condition.attack, row.condition.strength)
        yield Telling(OFTEN, scenario, intention, (attacked.unattacked, attacked))


def _textured(seen: _Seen, detector: str) -> Iterator[Telling]:
    attacked = seen.strongest(detector, PERTURBATIONS[-1:])
    replaced = seen.strongest(detector, (TEXTURE_ATTACKED,))
    if attacked is None or replaced is None:
        return
    for number, scenario in _most(seen.beside(attacked), seen.outcomes.scenarios):
        if number:
            conditions = (attacked.unattacked, attacked, replaced)
            yield Telling(TEXTURED, scenario, Intention.STRAIGHT, conditions)


def _flips_of(
    seen: _Seen, detector: str, attacks: Sequence[str]
) -> dict[tuple[str, Intention], list[Flip]]:
    """Of each episode, in the order of conditions; in float."""
    found: dict[tuple[str, Intention], list[Flip]] = {}
    for row in seen.flips():
        condition = row.condition
        own = condition.detector == detector and condition.attack in attacks
        if own and not condition.whole_levels:
            key = (row.scenario, Intention(row.intention))
            found.setdefault(key, []).append(row)
    return found


def _often_first(item: tuple[tuple[str, Intention], list[Flip]]) -> tuple[int, str]:
    key, rows = item
    attacks = Counter(row.condition.attack for row in rows)
    return -len(attacks), f"{key[0]} {list(Intention).index(key[1])}"


def _most(counts: Sequence[int], scenarios: Sequence[str]) -> list[tuple[int, str]]:
    """The largest first; of equal ones the first scenario."""
    return sorted(zip(counts, scenarios, strict=True), key=lambda pair: (-pair[0], pair[1]))
