"""What the demo has seen, in numbers and sentences: cars found, and episodes that stayed safe."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby

from avsec_gym.evaluation.contested import is_contested
from avsec_gym.experiments.chapter5.attack_names import detector_name
from avsec_gym.experiments.chapter5.flips import flips
from avsec_gym.experiments.chapter5.outcomes import Outcomes
from avsec_gym.experiments.chapter5.section.telling_scenes import Telling, telling_scenes
from avsec_gym.experiments.chapter5.seen import found_cars
from avsec_gym.experiments.chapter5.settings import PERTURBATIONS, UNATTACKED
from avsec_gym.experiments.demo.patch_in_words import demo_attack_name
from avsec_gym.experiments.json_rows import keyed
from avsec_gym.kitti.detections import above
from avsec_gym.scenario.frame_scenes import FrameScenes
from avsec_gym.scenario.intention import Intention

Way = tuple[str, Intention]
"""A scene and a driving intention in it."""
HIT = "it is the first episode in which something is in the way that this attack makes unsafe"
"""Why an episode is shown."""


@dataclass(frozen=True)
class StoryRow:
    """What a detector sees under an attack, and how the car drives by it.

    Args:
        detector: The detector.
        attack: The attack.
        strength: The attack's strength.
        cars: Number of labelled cars in all scenes.
        found: How many of them are found, as where a plan is made: by boxes above the threshold.
        episodes: Number of contested episodes; ``drives`` in files, whose format it is.
        safe: How many of these are safe.
    """

    detector: str
    attack: str
    strength: float
    cars: int
    found: int
    episodes: int = field(metadata=keyed("drives"))
    safe: int

    @property
    def name(self) -> str:
        """What the attack is called."""
        return demo_attack_name(self.attack, self.strength)


def contested_ways(scenes: FrameScenes) -> frozenset[Way]:
    """The episodes in which it matters what the car sees, see `is_contested`."""
    return frozenset(
        (scene.id, way)
        for scene in scenes.scenes.labelled
        for way in Intention
        if is_contested(scene, way)
    )


def story_rows(outcomes: Outcomes, ways: Collection[Way], threshold: float) -> list[StoryRow]:
    """A row for each detector and attack, of perturbations their last step.

    Args:
        outcomes: The outcomes of a run.
        ways: The contested episodes.
        threshold: The least score of a detection that is planned on.
    """
    rows = []
    for condition in outcomes.strongest:
        seen = outcomes.detections(condition, outcomes.looks(condition)[0])
        found = [
            found_cars(above(boxes, threshold), outcomes.labels[scenario])
            for scenario, boxes in zip(outcomes.scenarios, seen, strict=True)
        ]
        episodes = [
            record
            for record in outcomes.records(condition)
            if (record.scenario, record.intention) in ways
        ]
        rows.append(
            StoryRow(
                condition.detector,
                condition.attack,
                condition.strength,
                cars=sum(len(each) for each in found),
                found=sum(int(each.sum()) for each in found),
                episodes=len(episodes),
                safe=sum(record.safe for record in episodes),
            )
        )
    return rows


def sentences(rows: Sequence[StoryRow]) -> Iterator[str]:
    """What happened, a sentence for each detector, after one of what was tried.

    Args:
        rows: The story.
    """
    episodes = max((row.episodes for row in rows), default=0)
    if not episodes:
        return
    yield (
        f"In each of these {episodes} episodes something is in the way: a car that sees nothing"
        " drives unsafely, one that sees all drives safely."
    )
    for detector, group in groupby(rows, lambda row: row.detector):
        own = list(group)
        clean = [row for row in own if row.attack == UNATTACKED]
        for before in clean:
            attacked = "".join(
                f"; {row.name}: {row.found} cars, safely in {row.safe}"
                for row in own
                if row.attack != UNATTACKED
            )
            yield (
                f"{detector_name(detector)} finds {before.found} of {before.cars} cars, and the car"
                f" drives safely in {before.safe} of {episodes}{attacked}."
            )


def hits(outcomes: Outcomes, ways: Collection[Way], count: int, threshold: float) -> list[Telling]:
    """The episodes to show: for each detector the first made unsafe by an attack, then others.

    The perturbation's come first, then those of patches; where there are fewer than asked for,
    `telling_scenes` has the rest.  No scene is shown twice.

    Args:
        outcomes: The outcomes of a run.
        ways: The contested episodes.
        count: The largest number of episodes.
        threshold: The least score of a detection that is planned on.
    """
    chosen: dict[str, Telling] = {}
    strongest = sorted(outcomes.strongest, key=lambda one: one.attack not in PERTURBATIONS)
    for condition in strongest:
        for flip in flips(outcomes):
            way = (flip.scenario, Intention(flip.intention))
            if flip.condition == condition and way in ways and flip.scenario not in chosen:
                chosen[flip.scenario] = Telling(HIT, *way, (condition.unattacked, condition))
                break
    for telling in telling_scenes(outcomes, count, threshold):
        chosen.setdefault(telling.scenario, telling)
    return list(chosen.values())[:count]
