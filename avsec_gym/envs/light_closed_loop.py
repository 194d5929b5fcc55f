"""`avsec/ClosedLoop-v0` without highway-env: the same drives, bit for bit, in half the time.

Recorded traffic and continuous actions are all that it has.  The vector forms have many of these,
and `avsec drive` drives in one where a setting allows it.
"""

from __future__ import annotations

import math
from functools import cached_property, lru_cache
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.closed_loop.belief import Belief
from avsec_gym.closed_loop.drive_log import DriveLog
from avsec_gym.closed_loop.drive_record import DriveRecord, Outcome
from avsec_gym.closed_loop.light.beliefs import LightPerception, light_perception
from avsec_gym.closed_loop.light.light_drive import LightDrive, Place
from avsec_gym.closed_loop.loop_scenes import LoopScenes, loop_scenes
from avsec_gym.closed_loop.surroundings import Surroundings
from avsec_gym.closed_loop.traffic_scene import TrafficScene
from avsec_gym.envs.closed_loop import ClosedLoopEnv
from avsec_gym.envs.closed_loop_actions import checked_driving
from avsec_gym.envs.closed_loop_info import SoFar, drive_info
from avsec_gym.envs.closed_loop_observation import EACH, OWN
from avsec_gym.envs.closed_loop_view import show
from avsec_gym.envs.reset_options import reset_options
from avsec_gym.scenario.intention import Intention, intentions_named
from avsec_gym.scenario.planning_scenario import EgoState

ACCELERATION, STEERING = 8.0, math.pi / 4
"""What an action of 1 stands for: m/s2 and radians, to the right."""
_OBJECTS = 16
_FEW = 4
"""Scenes that stay laid out where one is driven in after the other."""
_GAINED = {Outcome.GOAL: 1.0, Outcome.COLLISION: -1.0, Outcome.OFF_ROAD: -1.0}


class SharedScenes:
    """Scenes to drive in, which any number of light drives share.

    Args:
        scenarios: Live scenes, or the arguments of `loop_scenes`.
        duration: Seconds that a drive takes at most.
        kept: Scenes that stay laid out.
    """

    def __init__(self, scenarios: Any, duration: float, kept: int) -> None:
        self._scenarios, self.duration, self._kept = scenarios, duration, kept
        self.place = lru_cache(kept)(self._place)

    @cached_property
    def scenes(self) -> LoopScenes:
        """The scenes, read when they are first needed."""
        live = isinstance(self._scenarios, LoopScenes)
        scenes = self._scenarios if live else loop_scenes(**self._scenarios)
        return LoopScenes(scenes.ids, lru_cache(self._kept)(scenes.make))

    def _place(self, scene: TrafficScene) -> Place:
        return Place.of(scene, self.duration)


class LightClosedLoopEnv(gym.Env[NDArray[np.float32], NDArray[np.float32]]):
    """`ClosedLoopEnv` as arrays and kernels; its page states what is observed, done and rewarded.

    A drive is the one that `ClosedLoopEnv` makes from the same seed: states, outcome, metrics and
    beliefs are the same numbers.  Observation, reward and what `info` reports before the end differ
    by rounding.

    Args:
        shared: The scenes.
        perception: The car's perception; no other drive may use it.
        planner: The planner of `PlannerDriver`, as `ClosedLoopEnv` has it.
    """

    metadata = {"render_modes": []}  # noqa: RUF012 - Gymnasium's.
    action_ranges = ((-ACCELERATION, ACCELERATION), (-STEERING, STEERING))
    """Acceleration, m/s2, and steering angle, radians to the right, of actions from -1 to 1."""

    def __init__(self, shared: SharedScenes, perception: LightPerception, planner: Any) -> None:
        self.action_space = gym.spaces.Box(-1.0, 1.0, (2,), np.float32)
        self.observation_space = gym.spaces.Box(-1.0, 1.0, (OWN + EACH * _OBJECTS,), np.float32)
        self.shared, self.perception, self.planner = shared, perception, planner
        self.duration = shared.duration
        self.unread_until = 0.0
        """Not used: every frame is perceived, which costs little here."""
        self.drive: LightDrive | None = None
        """The present drive; each reset begins another one."""
        self.controls = (0.0, 0.0)
        """Acceleration, m/s2, and steering angle, radians to the left, that were asked for last."""

    @property
    def scenes(self) -> LoopScenes:
        """The scenes to drive in."""
        return self.shared.scenes

    @property
    def _driven(self) -> LightDrive:
        if self.drive is None:
            raise gym.error.ResetNeeded("call reset before step")
        return self.drive

    @property
    def scene(self) -> TrafficScene:
        """Where the present drive takes place."""
        return self._driven.place.scene

    @property
    def intention(self) -> Intention:
        """Where the car wants to go."""
        return self._driven.intention

    @property
    def outcome(self) -> Outcome | None:
        """How the drive ended; None: it goes on."""
        return self._driven.outcome

    @property
    def record(self) -> DriveRecord | None:
        """Metrics of the drive; None: it goes on."""
        return self._driven.record

    @property
    def state(self) -> EgoState:
        """The car's state."""
        return self._driven.state

    @property
    def elapsed(self) -> float:
        """Seconds since the start of the drive."""
        return self._driven.elapsed

    @property
    def remaining(self) -> tuple[float, float]:
        """Metres to the goal, and the share of the time that is left."""
        return self._driven.remaining

    def surroundings(self) -> Surroundings:
        """The truth at this instant."""
        return self._driven.surroundings()

    def log(self) -> DriveLog:
        """What happened so far."""
        return self._driven.log()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin a drive; ``options`` may pick a ``scenario`` and an ``intention``.

        Raises:
            ConfigurationError: There is no such scene, or it has no lane for the intention.
        """
        super().reset(seed=seed)
        given = reset_options(options)
        # The same draws as `ClosedLoopEnv`'s.
        scene, intention = self.scenes.draw(
            self.np_random, given.get("scenario"), intentions_named(given.get("intention"))
        )
        self.drive = LightDrive(self.shared.place(scene), intention)
        self.controls = (0.0, 0.0)
        self.perception.begin(int(self.np_random.integers(2**31)))
        self.belief: Belief = self.perception.perceive(self.drive)
        return self._observe(), self._info()

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Drive on for a tenth of a second.

        Raises:
            ResetNeeded: There was no reset before.
            ConfigurationError: The action does not fit the space, or is not finite.
        """
        drive = self._driven
        asked = np.clip(checked_driving(action, self.action_space), -1.0, 1.0).tolist()
        # As highway-env scales actions, which steers to the right.
        acceleration, steering = (
            low + (value + 1.0) * (high - low) / 2
            for value, (low, high) in zip(asked, self.action_ranges, strict=True)
        )
        self.controls = (acceleration, -steering)
        drive.step(*self.controls)
        self.belief = self.perception.perceive(drive)
        terminated = drive.outcome in _GAINED
        reward = drive.progressed / drive.aim.distance
        if terminated:
            reward += _GAINED[drive.outcome]  # type: ignore[index]
        truncated = drive.outcome is not None and not terminated
        return self._observe(), reward, terminated, truncated, self._info()

    def _observe(self) -> NDArray[np.float32]:
        row = np.empty(self.observation_space.shape or (), np.float32)
        show(self._driven, self.belief, row)
        return row

    def _info(self) -> dict[str, Any]:
        drive = self._driven
        so_far = SoFar(drive.elapsed, drive.path_length, drive.reached.progress)
        return {
            **drive_info(drive.record, drive.place.scene.id, str(drive.intention), so_far),
            "speed": float(drive.car[2]),
            "crashed": bool(drive.crashed),
            "alarm": False,  # Nothing here reads sensors.
            "alarms": 0,
        }


def light_form(environment: ClosedLoopEnv) -> LightClosedLoopEnv | None:
    """The same drives without highway-env; None where only highway-env has what is asked for.

    Args:
        environment: The environment; its perception is the light one's now.
    """
    recorded = environment.reacting.is_recorded
    is_drawn = environment.render_mode is not None
    if environment.has_sensors or is_drawn or not (recorded and environment.has_usual_config):
        return None
    shared = SharedScenes(environment.scenes, environment.duration, _FEW)
    perception = light_perception(environment.perception, environment.motion)
    return LightClosedLoopEnv(shared, perception, environment.planner)
