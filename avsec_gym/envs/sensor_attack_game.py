"""The game behind attacks on sensors: scenes that a car drives safely without an attack."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from avsec_gym.attacks.attack import quantised
from avsec_gym.boxes import Boxes3D
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
class Look:
    """One query: what the car sees, believes and does."""

    frame: SensorFrame
    """What its sensors deliver; images have whole grey levels."""
    perception: Perception
    drive: Episode
    report: ValidatorReport


@dataclass(frozen=True, eq=False)
class Situation:
    """One scene with one driving intention."""

    scene: Scene
    intention: Intention
    unattacked: Look
    """What the car sees, believes and does without an attack."""


class SensorAttackGame:
    """Scenes with sensor data, and the car that drives through them.

    What the car sees and does without an attack is computed once for each scene, and kept.  The
    validator only reports whether it detects an attack: the car drives on.

    Args:
        parts: The scenes and the parts of the victim.
        contested: Draw only situations that are unsafe for a car which sees no object at all: in
            all others, to hide objects changes nothing.

    Raises:
        ConfigurationError: Arguments of a part do not fit, or no scene is left to be played.
        DataError: A file is missing or broken.
    """

    def __init__(self, parts: Parts, *, contested: bool = False) -> None:
        self.pipeline = parts.pipeline()
        self.validator, self.scenes = parts.validator_and_scenes()
        self.contested = contested
        self._labelled = {scene.id: scene for scene in self.scenes.scenes.labelled}
        self._ids = list(self._labelled)
        self._perceptions: dict[str, Perception] = {}
        self._reports: dict[str, ValidatorReport] = {}
        self._drives: dict[tuple[str, Intention], Episode] = {}
        self._blind_safe: dict[tuple[str, Intention], bool] = {}

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
            return self.situation(scene, intentions[int(random.integers(len(intentions)))])
        # All situations in a random order: the first one that fits is drawn.
        every = [(id, intention) for id in self._ids for intention in intentions]
        for k in random.permutation(len(every)):
            scene, intention = self._labelled[every[k][0]], every[k][1]
            if self.contested and not self.is_contested(scene, intention):
                continue
            situation = self.situation(scene, intention)
            unattacked = situation.unattacked
            if unattacked.drive.record.safe and not unattacked.report.alarm:
                return situation
        raise ConfigurationError(
            f"no scene of {self.scenes.scenes.name} is driven safely"
            f"{' and without an alarm' * (self.validator is not None)} while there is no attack:"
            " nothing to attack (is the detector trained, and its score threshold right?)"
        )

    def situation(self, scene: Scene, intention: Intention) -> Situation:
        """A scene with an intention, and what happens without an attack."""
        frame = self.scenes.frame(scene)
        if scene.id not in self._perceptions:
            self._perceptions[scene.id] = self._perceived(frame)
            self._reports[scene.id] = ValidatorReport.of(self.validator, frame)
        perception, key = self._perceptions[scene.id], (scene.id, intention)
        if key not in self._drives:
            self._drives[key] = self.pipeline.run_episode(scene, perception, intention)
        report = self._reports[scene.id]
        return Situation(scene, intention, Look(frame, perception, self._drives[key], report))

    def query(self, situation: Situation, frame: SensorFrame) -> Look:
        """Let the car see a frame and drive; images are rounded to whole grey levels first."""
        frame = quantised(frame)
        perception = self._perceived(frame)
        drive = self.pipeline.run_episode(situation.scene, perception, situation.intention)
        return Look(frame, perception, drive, ValidatorReport.of(self.validator, frame))

    def is_contested(self, scene: Scene, intention: Intention) -> bool:
        """Whether a car that sees nothing drives unsafely, so that hiding objects may matter."""
        key = (scene.id, intention)
        if key not in self._blind_safe:
            nothing = Perception(Boxes3D.empty(), Boxes3D.empty(), None)
            self._blind_safe[key] = self.pipeline.run_episode(scene, nothing, intention).record.safe
        return not self._blind_safe[key]

    def _perceived(self, frame: SensorFrame) -> Perception:
        with one_thread():
            return self.pipeline.perceive(frame)

    def _named(self, id: str) -> Scene:
        if id not in self._labelled:
            measured_on = "" if self.validator is None else ", other than those of thresholds"
            raise ConfigurationError(
                f"{self.scenes.scenes.name} has no scene {id!r} to play{measured_on}; the first is "
                f"{self._ids[0]!r}"
            )
        return self._labelled[id]
