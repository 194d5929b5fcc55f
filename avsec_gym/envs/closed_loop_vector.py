"""The vectorised entry point of `avsec/ClosedLoop-v0`: drives as arrays, without highway-env."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from avsec_gym.argument_checks import number, one_of, whole_number
from avsec_gym.closed_loop.belief import Belief
from avsec_gym.closed_loop.drive_record import Outcome
from avsec_gym.closed_loop.light.beliefs import Believed, belief_of_light
from avsec_gym.closed_loop.light.light_drive import LightDrive, Place
from avsec_gym.closed_loop.loop_scenes import LoopScenes, loop_scenes
from avsec_gym.closed_loop.traffic import REACTING, RECORDED
from avsec_gym.closed_loop.traffic_scene import DURATION, TrafficScene
from avsec_gym.envs.closed_loop import REFUSED
from avsec_gym.envs.closed_loop_info import SoFar, drive_info
from avsec_gym.envs.closed_loop_observation import EACH, OWN
from avsec_gym.envs.closed_loop_parts import checked_scenarios, light_perceptions, perception_of
from avsec_gym.envs.closed_loop_view import show
from avsec_gym.envs.parts import parts_of, takes_parts
from avsec_gym.envs.reset_options import reset_options
from avsec_gym.envs.vector_resets import generators_of, mask_of
from avsec_gym.errors import ConfigurationError
from avsec_gym.registry import Kind
from avsec_gym.scenario.intention import intentions_named
from avsec_gym.scenario.scene import Motion

MOST_ENVIRONMENTS = 4096
"""Each has a drive of its own."""
ACCELERATION, STEERING = 8.0, math.pi / 4
"""What an action of 1 stands for: m/s2 and radians, to the right."""
_OBJECTS = 16
_PLACES = 512
"""Scenes that stay laid out."""
_ALONE = 'make single environments: gym.make_vec(..., vectorization_mode="sync")'


@takes_parts(Kind.PLANNER, refused=REFUSED, scenarios="layouts", motion="truth")
class ClosedLoopVectorEnv(VectorEnv[NDArray[np.float32], NDArray[np.float32], NDArray[np.float64]]):
    """`ClosedLoopEnv` many times over; see there for the arguments.

    ``gym.make_vec("avsec/ClosedLoop-v0", num_envs=64)`` makes it.  Recorded traffic, continuous
    actions and the observation of one flat vector are what it has; perception by ``"truth"``,
    ``"blind"`` or an error model.  What else a single environment has is refused.

    A drive that has ended begins anew at the next step, whose action is not used (autoreset mode
    NEXT_STEP).  Environment i, seeded with s, drives what a single environment seeded with s + i
    drives; numbers differ by rounding alone.

    Raises:
        ConfigurationError: An argument is wrong, or one that only a single environment has.
    """

    title = "avsec/ClosedLoop-v0"
    metadata: dict[str, Any] = {  # noqa: RUF012 - as Gymnasium declares it
        "render_modes": [],
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    def __init__(
        self,
        num_envs: int = 1,
        perception: Any = "truth",
        traffic: str = RECORDED,
        duration: float = DURATION,
        config: dict[str, Any] | None = None,
        render_mode: str | None = None,
        **parts: Any,
    ) -> None:
        taken = parts_of(self, parts)
        if one_of("traffic", traffic, (RECORDED, REACTING)) != RECORDED:
            raise ConfigurationError(f"many drives at once have recorded traffic: {_ALONE}")
        if config is not None:
            raise ConfigurationError(f"many drives at once have no config: {_ALONE}")
        if render_mode is not None:
            raise ConfigurationError(f"many drives at once are not rendered: {_ALONE}")
        self.render_mode = None
        self.num_envs = whole_number("num_envs", num_envs, 1, MOST_ENVIRONMENTS)
        self.duration = number("duration", duration, 0.5, 30.0)
        made, self.planner = perception_of(perception, taken)
        self._perceptions = light_perceptions(made, Motion.named(taken.motion), self.num_envs)
        self._scenarios = checked_scenarios(taken.scenarios)
        self._scenes: LoopScenes | None = None
        self.single_action_space = gym.spaces.Box(-1.0, 1.0, (2,), np.float32)
        self.single_observation_space = gym.spaces.Box(
            -1.0, 1.0, (OWN + EACH * _OBJECTS,), np.float32
        )
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.drives: list[LightDrive] = []
        """The present drive of each environment."""
        self._believed: list[Believed] = []
        self._generators: list[np.random.Generator] = []
        self._place = lru_cache(_PLACES)(self._laid_out)

    @property
    def scenes(self) -> LoopScenes:
        """The scenes to drive in, read when they are first needed."""
        if self._scenes is None:
            live = isinstance(self._scenarios, LoopScenes)
            scenes = self._scenarios if live else loop_scenes(**self._scenarios)
            self._scenes = replace(scenes, make=lru_cache(_PLACES)(scenes.make))
        return self._scenes

    @property
    def ended(self) -> NDArray[np.bool_]:
        """Whose drive is over, and begins anew at the next step, shape (num_envs,)."""
        return np.array([drive.outcome is not None for drive in self.drives], bool)

    def belief(self, number: int) -> Belief:
        """What the car of an environment believes, as a planner reads it."""
        return belief_of_light(self.drives[number], self._believed[number])

    def reset(
        self,
        *,
        seed: int | list[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin all drives, or those of ``options["reset_mask"]``.

        Raises:
            ConfigurationError: There is no such scene, or it has no lane for the intention.
        """
        options = reset_options(options, "reset_mask")
        mask = mask_of(options.pop("reset_mask", np.ones(self.num_envs, bool)), self.num_envs)
        self._generators = generators_of(seed, self.num_envs, self._generators)
        if not self.drives:
            mask[:] = True
            self.drives = [None] * self.num_envs  # type: ignore[list-item]
            self._believed = [None] * self.num_envs  # type: ignore[list-item]
        for i in np.flatnonzero(mask).tolist():
            self._begin(i, options)
        return self._observe(), self._info()

    def step(  # type: ignore[override]
        self, actions: NDArray[np.float32]
    ) -> tuple[
        NDArray[np.float32],
        NDArray[np.float64],
        NDArray[np.bool_],
        NDArray[np.bool_],
        dict[str, Any],
    ]:
        """Drive on everywhere for a tenth of a second; drives that are over begin anew instead.

        Raises:
            ResetNeeded: There was no reset before.
            ConfigurationError: The actions do not fit the space, or are not finite.
        """
        if not self.drives:
            raise gym.error.ResetNeeded("call reset before step")
        actions = np.array(actions, float)
        if actions.shape != (self.num_envs, 2) or not np.isfinite(actions).all():
            raise ConfigurationError(
                f"actions have shape {(self.num_envs, 2)} and finite values, got {actions.shape}"
            )
        # highway-env steers to the right.
        wanted = (np.clip(actions, -1.0, 1.0) * (ACCELERATION, -STEERING)).tolist()
        rewards = np.zeros(self.num_envs)
        for i, drive in enumerate(self.drives):
            if drive.outcome is not None:
                self._begin(i, {})
                continue
            drive.step(*wanted[i])
            self._believed[i] = self._perceptions[i].perceive(drive)
            rewards[i] = _reward(drive)
        outcomes = [drive.outcome for drive in self.drives]
        terminated = np.array([each in _TERMINAL for each in outcomes], bool)
        truncated = np.array([each in _OVERTIME for each in outcomes], bool)
        return self._observe(), rewards, terminated, truncated, self._info()

    def _begin(self, number: int, options: dict[str, Any]) -> None:
        """Choose a scene, and put the car on it: the same draws as a single environment's."""
        generator = self._generators[number]
        scene, intention = self.scenes.draw(
            generator, options.get("scenario"), intentions_named(options.get("intention"))
        )
        drive = LightDrive(self._place(scene), intention)
        perception = self._perceptions[number]
        perception.begin(int(generator.integers(2**31)))
        self.drives[number], self._believed[number] = drive, perception.perceive(drive)

    def _laid_out(self, scene: TrafficScene) -> Place:
        return Place.of(scene, self.duration)

    def _observe(self) -> NDArray[np.float32]:
        rows = np.zeros(self.observation_space.shape or (), np.float32)
        for drive, believed, row in zip(self.drives, self._believed, rows, strict=True):
            show(drive, believed, row)
        return rows

    def _info(self) -> dict[str, Any]:
        rows = [_info_of(drive) for drive in self.drives]
        info: dict[str, Any] = {}
        for name, value in rows[0].items():
            kind = object if isinstance(value, str) else type(value)
            info[name] = np.array([row[name] for row in rows], kind)
            info[f"_{name}"] = np.ones(self.num_envs, bool)
        return info


_TERMINAL = (Outcome.GOAL, Outcome.COLLISION, Outcome.OFF_ROAD)
_OVERTIME = (Outcome.STOPPED, Outcome.TIME)


def _reward(drive: LightDrive) -> float:
    gained = {Outcome.GOAL: 1.0, Outcome.COLLISION: -1.0, Outcome.OFF_ROAD: -1.0}
    made = drive.progressed / drive.aim.distance
    return made if drive.outcome is None else made + gained.get(drive.outcome, 0.0)


def _info_of(drive: LightDrive) -> dict[str, Any]:
    so_far = SoFar(drive.elapsed, drive.path_length, drive.reached.progress)
    return {
        **drive_info(drive.record, drive.place.scene.id, str(drive.intention), so_far),
        "speed": float(drive.car[2]),
        "crashed": drive.crashed,
    }
