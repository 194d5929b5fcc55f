"""The game behind attacks on sensors: scenes that a car drives safely without an attack."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from avsec_gym.attacks.attack import quantised
from avsec_gym.envs.one_thread import one_thread
from avsec_gym.envs.parts import Parts
from avsec_gym.envs.reset_options import reset_options
from avsec_gym.envs.validator_report import ValidatorReport
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.pipeline import Episode, Perception
from avsec_gym.scenario.intention import Intention, intentions_named
from avsec_gym.scenario.scene import Scene


@dataclass(frozen=True, eq=False)
class QueryOutcome:
    """One query: what the car sees, believes and does."""

    frame: SensorFrame
    """What its sensors deliver; images have whole grey levels."""
    perception: Perception
    episode: Episode

    @property
    def report(self) -> ValidatorReport:
        """What the validator reports of the frame."""
        return ValidatorReport.of(self.perception.validation)


@dataclass(frozen=True, eq=False)
class Situation:
    """One scene with one driving intention."""

    scene: Scene
    intention: Intention
    unattacked: QueryOutcome
    """What the car sees, believes and does without an attack."""


class SensorAttackGame:
    """Scenes with sensor data, and the car that drives through them.

    What the car sees and does without an attack is computed once for each scene, and kept.

    Args:
        parts: The scenes and the parts of the victim.

    Raises:
        ConfigurationError: Arguments of a part do not fit, or no scene is left to be played.
        DataError: A file is missing or broken.
    """

    def __init__(self, parts: Parts) -> None:
        self.pipeline, self.scenes = parts.car()
        self._labelled = {scene.id: scene for scene in self.scenes.scenes.labelled}
        self._ids = list(self._labelled)
        self._perceptions: dict[str, Perception] = {}
        self._episodes: dict[tuple[str, Intention], Episode] = {}

    def draw(self, random: np.random.Generator, options: Mapping[str, Any] | None) -> Situation:
        """A situation that is worth an attack, or the one that options ask for.

        Without an attack, it is driven safely and raises no alarm.

        Raises:
            ConfigurationError: No scene has the id, no such intention, or nothing is safe.
        """
        options = reset_options(options)
        intentions = intentions_named(options.get("intention"))
        if options.get("scenario") is not None:
            scene = self._named(str(options["scenario"]))
            intentions = scene.possible(intentions)
            return self.situation(scene, intentions[int(random.integers(len(intentions)))])
        # All situations in a random order: the first one that fits is drawn.
        plays = self.scenes.scenes.plays
        every = [(id, way) for id in self._ids for way in intentions if plays(id, way)]
        for k in random.permutation(len(every)):
            scene, intention = self._labelled[every[k][0]], every[k][1]
            situation = self.situation(scene, intention)
            unattacked = situation.unattacked
            if unattacked.episode.record.safe and not unattacked.report.alarm:
                return situation
        quietly = " and without an alarm" if self.pipeline.validator is not None else ""
        raise ConfigurationError(
            f"no scene of {self.scenes.scenes.name} is driven safely{quietly} while there is no"
            " attack:"
            " nothing to attack (is the detector trained, and its score threshold right?)"
        )

    def situation(self, scene: Scene, intention: Intention) -> Situation:
        """A scene with an intention, and what happens without an attack."""
        frame = self.scenes.frame(scene)
        if scene.id not in self._perceptions:
            self._perceptions[scene.id] = self._perceived(frame)
        perception, key = self._perceptions[scene.id], (scene.id, intention)
        if key not in self._episodes:
            self._episodes[key] = self.pipeline.run_episode(scene, perception, intention)
        return Situation(scene, intention, QueryOutcome(frame, perception, self._episodes[key]))

    def query(self, situation: Situation, frame: SensorFrame) -> QueryOutcome:
        """Let the car see a frame and drive; images are rounded to whole grey levels first."""
        frame = quantised(frame)
        perception = self._perceived(frame)
        episode = self.pipeline.run_episode(situation.scene, perception, situation.intention)
        return QueryOutcome(frame, perception, episode)

    def harms(self, look: QueryOutcome) -> bool:
        """Whether an episode is unsafe in spite of the validator.

        A car that stops at an alarm and touches nothing came to no harm; for one that drives on
        (`response` None), an alarm is what it asks for.
        """
        if look.episode.record.safe:
            return False
        if self.pipeline.response is None:
            return not look.report.alarm
        return look.episode.record.collision or not look.perception.stops

    def _perceived(self, frame: SensorFrame) -> Perception:
        with one_thread():
            return self.pipeline.perceive(frame)

    def _named(self, id: str) -> Scene:
        if id not in self._labelled:
            measured_on = (
                "" if self.pipeline.validator is None else ", other than those of thresholds"
            )
            raise ConfigurationError(
                f"{self.scenes.scenes.name} has no scene {id!r} to play{measured_on}; the first is "
                f"{self._ids[0]!r}"
            )
        return self._labelled[id]
