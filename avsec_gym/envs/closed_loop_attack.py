"""`avsec/ClosedLoopAttack-v0`: an attacker over time against a car that drives on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import flag, one_of
from avsec_gym.closed_loop.attack.attacked_perception import AttackedPerception
from avsec_gym.closed_loop.attack.drive_attack import DriveAttack
from avsec_gym.closed_loop.belief import belief_of
from avsec_gym.closed_loop.error_model.perception import ErrorModelPerception
from avsec_gym.closed_loop.loop_scenes import DRIVES
from avsec_gym.closed_loop.perception import BlindPerception, DrivePerception, TruthPerception
from avsec_gym.closed_loop.reacting import RECORDED
from avsec_gym.closed_loop.surroundings import Surroundings
from avsec_gym.closed_loop.traffic_scene import DURATION
from avsec_gym.envs.actions import checked_action
from avsec_gym.envs.closed_loop import REFUSED as DRIVES_REFUSE
from avsec_gym.envs.closed_loop import ClosedLoopEnv
from avsec_gym.envs.closed_loop_observation import EACH, OWN, about_the_car, nearest_objects
from avsec_gym.envs.closed_loop_parts import (
    BLIND,
    ERROR_MODEL,
    SENSING,
    SENSORS,
    TRUTH,
    check_sensing,
    perception_of,
    with_detector,
)
from avsec_gym.envs.drive_budget import DriveBudget, Spent
from avsec_gym.envs.drivers import driver_of
from avsec_gym.envs.judged_drives import JudgedDrives, is_safe, is_to_blame, seed_of
from avsec_gym.envs.light_closed_loop import ACCELERATION, STEERING, LightClosedLoopEnv
from avsec_gym.envs.parts import Parts, parts_of, takes_parts
from avsec_gym.envs.reset_options import reset_options
from avsec_gym.errors import ConfigurationError
from avsec_gym.registry import Kind, check, make
from avsec_gym.scenario.intention import Intention, intentions_named
from avsec_gym.scenario.scene import Motion

_OBJECTS = 16
_WHAT_HAPPENED = 5
"""Shares of frames and energy left, alarm, acceleration, steering."""
_OF_THE_DRIVE = ("scenarios", "planner", "motion", "classifier")
"""Parts that the drive itself takes; the others are those of the perception."""
_READING_NOTHING = (TruthPerception, BlindPerception, ErrorModelPerception)
"""Perceptions that no attack on sensors reaches."""
_MODES = ["human", "rgb_array"]
_DRAWS = 50
"""Draws for each scene of a set until it counts as one that no car drives safely."""


REFUSED = {
    **DRIVES_REFUSE,
    "attack": 'the agent plays it: `kind` names what it can do, such as "ghost"',
}
"""Parts that have no meaning here, with the reason."""


@takes_parts(Kind.ATTACK, refused=REFUSED, scenarios="drives", motion="truth")
class ClosedLoopAttackEnv(gym.Env[NDArray[np.float32], NDArray[np.float32]]):
    """Make a car drive unsafely by its own fault, over time and within a budget.

    ## Description
    A car drives for 8 s in traffic, as in `avsec/ClosedLoop-v0`: every half second it plans anew
    from the state that it has really reached, on what it believes then.  The attacker acts ten
    times a second.  What it puts up stays: a ghost at its place in the world, a hidden object
    hidden wherever it moves, until the attacker takes it down or the budget is spent.  An episode
    is one scene with one driving intention that the same car, with the same errors of perception,
    drives safely without an attack; that drive is made once, when the scene is first drawn.

    The attack counts where the car collides and is to blame by nuPlan's rule
    (`avsec_gym.closed_loop.fault`), or leaves the road.  A crash that is another one's fault does
    not count, nor that the car brakes for a ghost until the time is over.

    A constant spends the budget at the beginning; a rule that waits until something in the way is
    near makes more of it, and one that hides in the frames alone that the car plans from still
    more.  `python -m studies.constants` and `python -m studies.closed_loop_attackers` measure how
    often they win.

    ## Observation
    `Box(-1, 1, (177,), float32)`, 162 and what depends on the attack, values cut at 1.  13 numbers
    about the car and 9 about each of the 16 nearest objects as in `avsec/ClosedLoop-v0`, but the
    objects are the real ones.  What the attack has up, in the car's frame: for ``ghost`` of each
    ghost up, ahead / 50 m, left / 50 m, cos and sin of the heading, of each hide up, ahead / 50 m
    and left / 50 m of the hidden object.  Shares of the frames and of the energy that are left; 1
    where the validator raised an alarm about the last frame; the car's acceleration / 8 m/s2 and
    the angle that it steers to / 45 degrees (positive to the left).  Then the last action, zeros at
    first.

    ## Action
    `Box(-1, 1, (7,), float32)` for ``ghost``; it holds for the next frame.  Of each ghost, above 0:
    up; where it is laid, 5 to 45 m ahead and -8 to 8 m to the left of the car; its heading, -pi to
    pi.  Of each hide, above 0: hide the object nearest to a place, ahead and left as for ghosts.
    Places count when something is put up; to move a ghost, take it down first.  ``facula``, 5
    numbers: on; the right camera if above 0, else the left; ahead and left of the object that
    carries the laser; radius.  ``spoofed_scan``, 5 numbers: up; ahead and left; width; height.
    ``patch``, 5 numbers: up; on the vehicle nearest to a place if above 0, else at the place
    itself; ahead and left; diameter.  All is scaled linearly; the classes in
    `avsec_gym.closed_loop.attack` state the ranges.

    ## Reward
    1 when the attack counts, less 0.1 times the share of the energy that the frame took.  A frame
    takes 1 where all ghosts are up and all hides used, in proportion less for fewer; of a spot, a
    plane or a poster its area, as a share of the largest.  An action beyond the budget takes
    everything down.

    ## Episode end
    As the drive: terminated at the goal, at a collision and off the road; truncated when the time
    is over.

    ## Info
    What `avsec/ClosedLoop-v0` reports of the drive; `is_success` (the attack counts),
    `unattacked_safe` (the drive is safe without it), `frames` and `energy` (spent), `alarm` (of the
    last frame), `alarms` (frames with one; where sensors are read, a planner has only those frames
    perceived that it plans on); and of ``ghost`` `ghosts` and `hidden` (up now), of ``facula``
    `camera` (-1: off) and `radius` (pixels), of ``spoofed_scan`` `width` and `height` (metres), of
    ``patch`` `diameter` (metres) and `carried` (1: by a vehicle).

    ## Arguments
    * `kind="ghost"`: what the attacker can do.  Also `{"name": "ghost", "ghosts": 2, "hides": 0,
      "ahead": [5, 45], "left": [-8, 8]}`; `"facula"` (a laser on a real object, which tracks the
      car's camera), `"spoofed_scan"` (bogus LiDAR points at a place) and `"patch"` (a poster on a
      vehicle or at the roadside), which need a perception that reads what they attack (`"stereo"`
      or `"sensors"`; `"lidar"` or `"sensors"` for the scan) and `scenarios="drives"`; or a live
      `avsec_gym.closed_loop.attack.drive_attack.DriveAttack`.
    * `driver="planner"`: or `{"name": "planner", "replanning": 0.2}` (seconds); or `"idm"`,
      highway-env's own; or a live agent of `avsec/ClosedLoop-v0` that has
      `predict(observation, deterministic=True)`.
    * `frames=20`: budget of frames under attack, a tenth of a second each; `energy=15`: budget of
      energy; `price=0.1`: of the whole energy, from 0 to 1.
    * `contested=False`: with `True`, only drives that the car would make unsafely by its own fault
      if it believed in no object: where nothing is in the way, hiding changes nothing.
    * `perception="truth"`, `traffic="recorded"`, `duration=8.0`, `config=None`, and the car's parts
      (`scenarios="drives"`, `motion="truth"`, `planner="astar"`, `detector="dsgn"`,
      `classifier=None`, `selector=None`, `validator=None`, `response="stop"`,
      `score_threshold=0.3`): as of `avsec/ClosedLoop-v0`.  With a `validator` and `response=None` a
      car drives on at an alarm, and an attack counts only without one.
    * `render_mode`: None, `"rgb_array"` or `"human"`.

    `reset(options={"scenario": id, "intention": "left"})` picks a scene, safe or not; where the
    drive is unsafe without an attack, no attack succeeds.

    ## Versions
    * v0: first.
    """

    title = "avsec/ClosedLoopAttack-v0"
    metadata = {"render_modes": _MODES, "render_fps": 10}  # noqa: RUF012 - Gymnasium's.

    def __init__(
        self,
        *,
        kind: Any = "ghost",
        driver: Any = "planner",
        perception: Any = "truth",
        traffic: Any = RECORDED,
        duration: float = DURATION,
        frames: int = 20,
        energy: float = 15.0,
        price: float = 0.1,
        contested: bool = False,
        config: dict[str, Any] | None = None,
        render_mode: str | None = None,
        **parts: Any,
    ) -> None:
        if render_mode is not None:
            render_mode = one_of("render_mode", render_mode, _MODES)
        self.render_mode = render_mode
        self.budget = DriveBudget(frames, energy, price)
        self.contested = flag("contested", contested)
        check(Kind.DRIVE_ATTACK, kind)
        self.attack: DriveAttack = make(Kind.DRIVE_ATTACK, kind)
        taken = parts_of(self, with_detector(perception, parts))
        self.drives_on_at_alarms = taken.response is None
        _check_rates(config)
        self._seen = AttackedPerception(_checked(perception, taken, self.attack), self.attack)
        self._drives: dict[str, Any] = {
            "traffic": traffic,
            "duration": duration,
            "config": config,
            **{name: getattr(taken, name) for name in _OF_THE_DRIVE},
        }
        self.drive = self._driven_by(self._seen, render_mode=render_mode)
        self.driver, self._named_driver = driver_of(driver, self.drive), driver
        self._unattacked: JudgedDrives | None = None
        self._blind: JudgedDrives | None = None
        size = self.attack.action_size
        self.action_space = gym.spaces.Box(-1.0, 1.0, (size,), np.float32)
        seen = OWN + EACH * _OBJECTS + self.attack.state_size + _WHAT_HAPPENED + size
        self.observation_space = gym.spaces.Box(-1.0, 1.0, (seen,), np.float32)
        self._driven_on: Any = None

    @property
    def perception(self) -> DrivePerception:
        """The car's perception without the attack, made when it is first needed."""
        return self._seen.unattacked

    @property
    def unattacked(self) -> JudgedDrives:
        """The same drives without the attack."""
        if self._unattacked is None:
            self._unattacked = self._without_attack(self.perception)
        return self._unattacked

    @property
    def blind(self) -> JudgedDrives:
        """The same drives of a car that believes in no object."""
        if self._blind is None:
            self._blind = self._without_attack(BlindPerception())
        return self._blind

    def _without_attack(self, perception: DrivePerception) -> JudgedDrives:
        drive = self._driven_by(perception, scenarios=self.drive.scenes)
        return JudgedDrives(drive, driver_of(self._named_driver, drive))

    def _driven_by(
        self, perception: DrivePerception, **more: Any
    ) -> ClosedLoopEnv | LightClosedLoopEnv:
        """The car, which believes what a perception makes of the world."""
        return ClosedLoopEnv(perception=perception, **(self._drives | more))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begin a drive; ``options`` may pick a ``scenario`` and an ``intention``.

        Raises:
            ConfigurationError: There is no such scene, it has no lane for the intention, or no
                scene is driven safely without an attack.
        """
        super().reset(seed=seed)
        given = reset_options(options)
        scenario, intention = self._drawn(given.get("scenario"), given.get("intention"))
        where = {"scenario": scenario, "intention": str(intention)}
        self._driven_on, info = self.drive.reset(seed=seed_of(scenario, intention), options=where)
        self._spent, self._alarms = Spent(), int(self._seen.alarm)
        self._action = np.zeros(self.attack.action_size)
        return self._observe(), self._info(info)

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Attack the next frame, and let the car drive on for a tenth of a second."""
        if self._driven_on is None:
            raise gym.error.ResetNeeded("call reset before step")
        self._action = checked_action(action, self.attack.action_size)
        effort = self.attack.act(self._action, self._around)
        if not self._spent.allows(effort, self.budget):
            self.attack.begin()
            effort = 0.0
        self._spent = self._spent.more(effort)
        # The driver acts on what it believed before; then the car perceives the attacked frame.
        driving, _ = self.driver.predict(self._driven_on, deterministic=True)
        self._driven_on, _, terminated, truncated, info = self.drive.step(driving)
        self._alarms += self._seen.alarm and self._is_perceived
        reward = float(self._succeeds()) - self.budget.price * effort / self.budget.energy
        return self._observe(), reward, terminated, truncated, self._info(info)

    def render(self) -> Any:
        """The road from above, as highway-env draws it; what is really there."""
        if self.render_mode is None:
            gym.logger.warn('render() shows nothing: make it with render_mode="rgb_array"')
            return None
        return self.drive.render()

    def close(self) -> None:
        """Close the window."""
        self.drive.close()

    def _drawn(self, scenario: Any, wanted: Any) -> tuple[str, Intention]:
        """A drive that can be won; of a scene that was asked for, any drive."""
        scenes, intentions = self.drive.scenes, intentions_named(wanted)
        for _ in range(_DRAWS * len(scenes)):
            scene, intention = scenes.draw(self.np_random, scenario, intentions)
            self._unattacked_safe = is_safe(self.unattacked.record(scene.id, intention))
            if scenario is not None or (
                self._unattacked_safe
                and (not self.contested or is_to_blame(self.blind.record(scene.id, intention)))
            ):
                return scene.id, intention
        contested = " and, as contested=True asks for, unsafely by a blind car"
        raise ConfigurationError(
            f"no scene of this set is driven safely without an attack{contested * self.contested}, "
            "so there is nothing to attack: name other scenes, or another perception or driver"
        )

    @property
    def _is_perceived(self) -> bool:
        """Whether the car has perceived the present frame."""
        return self._seen.around.time == self.drive.elapsed

    @property
    def _around(self) -> Surroundings:
        """The truth around the car at the present instant."""
        return self._seen.around if self._is_perceived else self.drive.surroundings()

    def _succeeds(self) -> bool:
        """Whether a safe drive became unsafe by the car's own fault, in spite of the validator."""
        record = self.drive.record
        if record is None or not self._unattacked_safe:
            return False
        return is_to_blame(record) and not (self.drives_on_at_alarms and self._alarms)

    def _observe(self) -> NDArray[np.float32]:
        drive, around = self.drive, self._around
        truth = belief_of(TruthPerception().perceive(around), around, Motion.TRUTH)
        acceleration, steering = drive.controls
        happened = [
            *self._spent.left(self.budget),
            float(self._seen.alarm),
            acceleration / ACCELERATION,
            steering / STEERING,
        ]
        known = (
            about_the_car(drive.scene, drive.intention, drive.state, drive.remaining, drive.belief),
            nearest_objects(drive.state, truth, _OBJECTS).ravel(),
            self.attack.state(around),
            happened,
            self._action,
        )
        return np.clip(np.concatenate(known), -1.0, 1.0).astype(np.float32)

    def _info(self, drive: dict[str, Any]) -> dict[str, Any]:
        return {
            **drive,
            "is_success": self._succeeds(),
            "unattacked_safe": self._unattacked_safe,
            "frames": self._spent.frames,
            "energy": float(self._spent.energy),
            "alarm": self._seen.alarm,
            "alarms": self._alarms,
            **self.attack.facts,
        }


def _check_rates(config: dict[str, Any] | None) -> None:
    """Refuse frames of another length than a tenth of a second: budgets count frames.

    Raises:
        ConfigurationError: highway-env's configuration has other frequencies.
    """
    if not isinstance(config, Mapping):  # The drive itself refuses what is no dictionary.
        return
    for name, usual in ClosedLoopEnv.default_config().items():
        if name.endswith("_frequency") and config.get(name, usual) != usual:
            raise ConfigurationError(
                f"an attack's frames are a tenth of a second each: leave {name} at {usual}"
            )


def _checked(perception: Any, parts: Parts, attack: DriveAttack) -> Callable[[], DrivePerception]:
    """What makes the car's perception without the attack.

    Raises:
        ConfigurationError: The attack tampers with what this perception does not read.
    """
    level = perception.get("name") if isinstance(perception, Mapping) else perception
    level = level if isinstance(level, str) else None
    if attack.sensors and level in (TRUTH, BLIND, ERROR_MODEL):
        raise ConfigurationError(
            f'this attack tampers with sensor data, which perception="{level}" does not read: '
            f'give perception="{SENSORS}" and scenarios="{DRIVES}"'
        )
    if attack.sensors and isinstance(perception, _READING_NOTHING):
        raise ConfigurationError(
            f"this attack tampers with sensor data, which {type(perception).__name__} does not read"
        )
    if not attack.sensors and level in SENSING:
        raise ConfigurationError(
            f'this attack changes what the car believes, and perception="{level}" finds that in '
            f'sensor data: give perception="{TRUTH}" or an error model, or kind="facula"'
        )
    made, _ = perception_of(perception, parts)
    check_sensing(perception, parts, attack.sensors)
    return made if callable(made) else lambda: made
