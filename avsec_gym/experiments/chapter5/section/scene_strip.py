"""Strips of pictures: one episode unattacked and attacked, each attack repeated for them.

A run keeps detections, not images.  Attacks are seeded, so the images are made again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from avsec_gym.attacks.attack import LEFT
from avsec_gym.boxes import Boxes3D
from avsec_gym.drawing.box_edges import edges_in_image
from avsec_gym.drawing.embedded_image import embedded
from avsec_gym.drawing.episode_drawing import draw_episode_from_above
from avsec_gym.drawing.turnable_scene.page_part import turnable_part
from avsec_gym.drawing.turnable_scene.scene_data import DrivenBelief, turnable_scene
from avsec_gym.experiments.chapter5.attack_names import AttackName, attack_name, detector_name
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.chapter5.section.telling_scenes import Telling
from avsec_gym.experiments.chapter5.seen import found_cars
from avsec_gym.frame import SensorFrame
from avsec_gym.geometry import Floats, box_corners
from avsec_gym.kitti.labels import DONT_CARE
from avsec_gym.metrics.ghosts import ghosts
from avsec_gym.metrics.safety import SafetyRecord
from avsec_gym.pipeline import PipelineRun
from avsec_gym.progress import Progress, no_progress
from avsec_gym.scenario.intention import Intention

_GREY = 128


class Repeats(Protocol):
    """What is needed of `avsec_gym.experiments.chapter5.attacked_episodes.AttackedEpisodes`."""

    def again(
        self,
        detector: str,
        attack: str,
        scenario: str,
        intention: Intention,
        strength: float = 0.0,
        *,
        whole_levels: bool = False,
    ) -> PipelineRun:
        """One episode of a run once more."""
        ...


@dataclass(frozen=True)
class EpisodeView:
    """One episode under one condition.

    Args:
        title: What was done.
        image: The left image, as a data URI.
        size: The view's width and height, pixels.
        real: Outlines of true objects in it, as paths of SVG.
        believed: Outlines of believed boxes.
        cars: Number of real cars that are found, and of all.
        ghosts: Number of believed boxes that stand for nothing.
        episode: The episode from above, as SVG.
        outcome: ``safe``, ``collision`` or ``unplanned``.
        explanation: The plan in a sentence.
        as_stored: Whether the episode has the outcome that the run stored.
    """

    title: str
    image: str
    size: tuple[int, int]
    real: tuple[str, ...]
    believed: tuple[str, ...]
    cars: tuple[int, int]
    ghosts: int
    episode: str
    outcome: str
    explanation: str
    as_stored: bool


@dataclass(frozen=True)
class SceneStrip:
    """Views of one episode, the unattacked first.

    Args:
        title: Detector, scene and intention.
        rule: Why it is shown.
        views: Two or more.
        difference: The amplified difference of the first two images, as a data URI.
        factor: The factor of amplification.
        largest: Change of any channel of any pixel, grey levels.
        turnable: The scene and its episodes in space.
    """

    title: str
    rule: str
    views: tuple[EpisodeView, ...]
    difference: str
    factor: int
    largest: float
    turnable: Markup


def scene_strips(
    telling: Sequence[Telling],
    outcomes: Outcomes,
    episodes: Repeats,
    on_progress: Progress = no_progress,
    name: AttackName = attack_name,
) -> list[SceneStrip]:
    """A strip for each episode.

    Args:
        telling: The episodes.
        outcomes: The outcomes of the run.
        episodes: The work that repeats them.
        on_progress: Function that gets the number that is done, and of all.
        name: The function that words attacks.

    Raises:
        DataError: An image is no longer there.
    """
    strips = []
    for number, one in enumerate(telling, start=1):
        strips.append(_strip(one, outcomes, episodes, name))
        on_progress(number, len(telling))
    return strips


def amplified(
    before: NDArray[np.number], after: NDArray[np.number]
) -> tuple[NDArray[np.uint8], int, float]:
    """The difference of two images about middle grey, the factor, and the largest difference.

    The factor is the largest whole number that keeps every difference within the grey levels.

    Example:
        >>> picture, factor, largest = amplified(np.zeros((1, 2, 3)), np.full((1, 2, 3), 4.0))
        >>> int(picture[0, 0, 0]), factor, largest
        (252, 31, 4.0)
    """
    change = np.asarray(after, float) - np.asarray(before, float)
    largest = float(np.abs(change).max())
    factor = max(1, int((_GREY - 1) // largest)) if largest else 1
    return np.clip(_GREY + factor * change, 0, 255).round().astype(np.uint8), factor, largest


def _strip(telling: Telling, outcomes: Outcomes, episodes: Repeats, name: AttackName) -> SceneStrip:
    runs = [
        episodes.again(
            condition.detector,
            condition.attack,
            telling.scenario,
            telling.intention,
            condition.strength,
            whole_levels=condition.whole_levels,
        )
        for condition in telling.conditions
    ]
    truth = outcomes.labels[telling.scenario]
    picture, factor, largest = amplified(*(run.frame.image(LEFT) for run in runs[:2]))
    detector = detector_name(telling.conditions[0].detector)
    title = f"{detector}, scene {telling.scenario}, {telling.intention}"
    names = [
        name(condition.attack, condition.strength, condition.whole_levels)
        for condition in telling.conditions
    ]
    driven = [
        DrivenBelief(words, run.episode, run.perception.believed)
        for words, run in zip(names, runs, strict=True)
    ]
    real = truth[truth.category != DONT_CARE]
    scene = turnable_scene(title, driven, real, frame=runs[0].frame)
    return SceneStrip(
        title=title,
        rule=telling.rule,
        views=tuple(
            _view(words, run, truth, _stored(outcomes, telling, condition))
            for words, condition, run in zip(names, telling.conditions, runs, strict=True)
        ),
        difference=embedded(picture),
        factor=factor,
        largest=largest,
        turnable=turnable_part(scene),
    )


def _view(title: str, run: PipelineRun, truth: Boxes3D, stored: SafetyRecord) -> EpisodeView:
    image = np.rint(np.clip(run.frame.image(LEFT), 0, 255)).astype(np.uint8)
    record, believed = run.episode.record, run.perception.believed
    found = found_cars(believed, truth)
    hit = f", but touches a real object after {record.collision_time:.1f} s"
    return EpisodeView(
        title=title,
        image=embedded(image),
        size=(image.shape[1], image.shape[0]),
        real=_outlines(run.frame, truth[truth.category != DONT_CARE]),
        believed=_outlines(run.frame, believed),
        cars=(int(found.sum()), len(found)),
        ghosts=int(ghosts(believed, truth).sum()),
        episode=draw_episode_from_above(run.episode),
        outcome=record.outcome,
        explanation=run.episode.plan.explanation + (hit if record.collision else ""),
        as_stored=(record.outcome, record.expanded) == (stored.outcome, stored.expanded),
    )


def _stored(outcomes: Outcomes, telling: Telling, condition: Condition) -> SafetyRecord:
    records = outcomes.records(condition, telling.intention)
    return next(record for record in records if record.scenario == telling.scenario)


def _outlines(frame: SensorFrame, boxes: Boxes3D) -> tuple[str, ...]:
    """A path for each box, as far as it lies before the camera."""
    projection = frame.calibration.projection(LEFT)
    corners = box_corners(boxes.location, boxes.dimensions, boxes.rotation_y)
    return tuple(path for box in corners if (path := _outline(box, projection)))


def _outline(corners: Floats, projection: Floats) -> str:
    parts: list[str] = []
    for pixels in edges_in_image(corners, projection):
        (u, v), (w, h) = np.clip(pixels, -5000, 5000)
        parts.append(f"M{u:.0f} {v:.0f}L{w:.0f} {h:.0f}")
    return "".join(parts)
