"""`avsec/ClosedLoop-v0`: drive on in traffic, by what the car believes, on highway-env."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium as gym
from highway_env.envs.common.abstract import AbstractEnv

from avsec_gym.argument_checks import number, one_of, whole_number
from avsec_gym.closed_loop.belief import Belief, belief_of
from avsec_gym.closed_loop.drive_log import DriveLog
from avsec_gym.closed_loop.drive_record import (
    DriveRecord,
    Outcome,
)
from avsec_gym.closed_loop.drive_recorder import DriveRecorder
from avsec_gym.closed_loop.fault import STANDING
from avsec_gym.closed_loop.loop_road import LoopRoad
from avsec_gym.closed_loop.loop_scenes import LoopScenes, loop_scenes
from avsec_gym.closed_loop.perception import DrivePerception, SensorPerception
from avsec_gym.closed_loop.reacting import RECORDED, reacting_of
from avsec_gym.closed_loop.road_frame import mirrored_angle
from avsec_gym.closed_loop.road_network import network_of
from avsec_gym.closed_loop.sensor_needs import sensing
from avsec_gym.closed_loop.surroundings import Surroundings
from avsec_gym.closed_loop.traffic import RoadTraffic
from avsec_gym.closed_loop.traffic_scene import DURATION
from avsec_gym.envs.closed_loop_actions import action_of, car_on_road, checked_driving
from avsec_gym.envs.closed_loop_info import SoFar, drive_info
from avsec_gym.envs.closed_loop_observation import checked_size, observation_of, observing_frames
from avsec_gym.envs.closed_loop_parts import (
    check_sensing,
    checked_handover,
    checked_scenarios,
    perception_of,
    sensors_read,
    with_detector,
)
from avsec_gym.envs.observations import FEATURES, FRAME, THUMBNAIL
from avsec_gym.envs.parts import parts_of, takes_parts
from avsec_gym.envs.reset_options import reset_options
from avsec_gym.errors import ConfigurationError
from avsec_gym.registry import Kind
from avsec_gym.scenario.intention import Intention, intentions_named
from avsec_gym.scenario.planning_scenario import EgoState
from avsec_gym.scenario.scene import Motion
from avsec_gym.suggestions import unknown_name

REFUSED = {
    "clean": "thresholds come as a table here, which `avsec validate` makes",
    "road": 'the scenes name it: "drives" are on the world\'s own road, "layouts" on the thesis\' '
    "lanes",
}
"""Parts that have no meaning here, with the reason."""


@takes_parts(Kind.PLANNER, refused=REFUSED, scenarios="drives", motion="truth")
class ClosedLoopEnv(AbstractEnv):  # type: ignore[misc]
    """Drive a car among recorded or reacting traffic, by what it believes.

    **Doing nothing wins often.**  Most of the default drives go straight on: a car that neither
    accelerates nor brakes nor steers reaches its goal in 63.0 % of 200 episodes, those of the seeds
    0 to 199 (95 % interval 51.5 to 73.2 %).  A driver is to be held against that figure; on
    `scenarios="layouts"`, where every intention has a lane, it is 26.5 % (20.7 to 33.3 %).

    ## Description
    A car drives for 8 s on a road of highway-env, in traffic that plays recorded tracks or reacts.
    At every step its perception turns what is really there into what it believes; the agent sees
    the belief, accelerates and steers.  The goal is a lane, by the driving intention, and a
    distance: five sixths of the way that the least cruising speed makes in the time (40 m on a
    street, 73 m on a highway of the labelled scenes).  Everything moves on in the meantime, and a
    collision is one with what is really there.  The car is the planner's BMW 320i (kinematic single
    track), 4.508 x 1.610 m, and never rolls backwards.

    `avsec_gym.envs.planner_driver.PlannerDriver` plays it by a motion planner that replans every
    0.5 s.  Sensors are then rendered at each replanning alone: what the planner does not read is
    left out, and beliefs, observations and alarms in between are those of the last replanning.
    `avsec_gym.envs.idm_driver.IdmDriver`, highway-env's own driver, is the other baseline.

    ## Observation
    `Box(-1, 1, (157,), float32)`: 13 numbers about the car, values cut at 1: speed / 25 m/s; angle
    of the wheels / 45 degrees; for the lane it is in and for the intended lane the distance to the
    left of its middle / 10 m, the heading against it / pi, and how far to the left it runs 15 m
    ahead / 10 m; the way to the goal / 100 m; the share of the time that is left; the least
    cruising speed / 25 m/s; 1 on a believed highway; 1 where the response to an alarm is an
    emergency stop.  Then the 16 nearest believed objects, in the car's frame (x forward, y left):
    present, x / 50 m, y / 20 m, vx and vy against the car / 25 m/s, cos and sin of the heading,
    length / 20 m, width / 4 m.

    `config={"observation": {"type": "Kinematics"}}` and highway-env's other types show believed
    objects in highway-env's form, too.

    With `observation="frame"`, where the perception reads images, `Dict`: `left` and `right`,
    `Box(0, 255, (48, 160, 3), uint8)`, the images of cameras 2 and 3 as the sensors delivered them,
    attacked or not, in another size; and `features`, the vector above.

    ## Action
    `Box(-1, 1, (2,), float32)`: acceleration, -8 to 8 m/s2, and the steering angle, -45 to 45
    degrees, positive to the right as in highway-env; both linear, 0 is none.  The wheels turn at
    0.4 rad/s at most.  `config={"action": {"type": "DiscreteMetaAction"}}` has highway-env's lanes
    and speeds, whose controllers then steer.

    ## Reward
    Progress along the road as a share of the way to the goal, and 1 for the goal, -1 for a
    collision or for leaving the road.

    ## Episode end
    Terminated at the goal, at a collision and off the road; truncated when the time is over, or a
    human takes over.

    ## Info
    `planned`, `success` (the drive came to its goal or collided), `collision`, `safe`
    (`is_success`: it reached its goal and touched nothing), `cost` (s; nan where a drive ended
    otherwise), `path_length` and `progress` along the road (m), `outcome` (`goal`, `collision`,
    `off_road`, `stopped`, `time`; `driving` before the end, `reset` at reset), `scenario`,
    `intention`; highway-env's `speed` and `crashed`; `alarm` (of the validator, now) and `alarms`
    (so many so far; frames that are left out raise none).  Known at the end: `smallest_distance`
    (m) and `time_to_collision` (s; the least of the drive, inf where none lies within 3 s, and
    before the end), `cost_sm1`, `at_fault` (1 where the car is to blame, by nuPlan's rule),
    `navsim_score` and its parts `no_collision`, `drivable`, `ttc_bound`, `progress_share`,
    `comfort` (0 before).

    ## Arguments
    * `scenarios="drives"`: 100 procedural drives on the world's own road, straight or bent, each
      made when it is first driven (0.2 s); `"layouts"`: procedural scenes on the thesis' straight
      lanes, where every intention has a lane, their movers at constant velocity;
      `"mixed_contested"`: those in which a blind car drives unsafely; a folder of labelled
      scenarios, of KITTI labels, or of CommonRoad files; or a dictionary such as
      `{"source": "drives", "seed": 1, "count": 20, "people": False}`, or
      `{"source": "kitti_tracking", "root": FOLDER}` (or `"kitti_raw"`): KITTI's recordings;
      `{"source": "kitti_contested", "kitti": FOLDER}`: the contested ones of a folder of labels.
      `{"source": "drives", "assets": "judge"}`: drives with cars that no detector was trained on.
    * `perception="truth"`: or `"blind"`; or `"lidar"`: a scan is rendered from where the car is,
      for a LiDAR detector (`"pixor"` where none is named); or `"stereo"`: a pair of images is, at
      the width that the detector reads (`"dsgn"`), a facula where it would lie in those of full
      width; or `"sensors"`: images of full width and a scan, as attacks on sensors and validators
      need them; or `{"name": "error_model", "model": FILE}`: errors drawn as those of a detector,
      without images; or a live `DrivePerception`.
    * `detector="dsgn"`, `attack=None`, `classifier=None`, `selector=None`, `validator=None`,
      `response="stop"`, `score_threshold=0.3`: the parts of cars with sensors, as everywhere; named
      beside another perception, they are refused.
    * `motion="truth"`: how the planner takes believed objects to move: as the true object that
      each overlaps most; `"static"`; with a `classifier` `"classifier"`, as it answers.
    * `planner="astar"`: of `PlannerDriver`.
    * `traffic="recorded"`: or `"reacting"`: vehicles that drive in a lane are driven by
      highway-env's IDM; or `{"name": "reacting", "share": 0.5}`, a share of them, which follows
      from the scene's id; or `{"name": "reacting", "ids": [3, 7]}`, actors by their ids (those of
      `surroundings().actors`).
    * `observation="features"`: or `"frame"`; `frame_size=(48, 160)`: height and width of its
      images, (375, 1242) as rendered for `"sensors"`.
    * `duration=8.0`: seconds.
    * `handover=None`: with a validator, seconds that the car stands by alarms until a human takes
      over, and the drive ends as `stopped`; None: it stands there until the time is over.
    * `config=None`: highway-env's configuration, what differs from the default.
    * `render_mode`: None, `"rgb_array"` or `"human"`.

    `reset(options={"scenario": id, "intention": "left"})` picks a scene; `options={"config":
    {...}}` changes highway-env's configuration.

    ## Versions
    * v0: first.
    """

    title = "avsec/ClosedLoop-v0"

    def __init__(
        self,
        *,
        perception: Any = "truth",
        traffic: Any = RECORDED,
        observation: str = FEATURES,
        frame_size: Sequence[int] = THUMBNAIL,
        duration: float = DURATION,
        handover: float | None = None,
        config: dict[str, Any] | None = None,
        render_mode: str | None = None,
        **parts: Any,
    ) -> None:
        modes: list[str] = AbstractEnv.metadata["render_modes"]
        if render_mode is not None:
            render_mode = one_of("render_mode", render_mode, modes)
        # highway-env writes the frame rate into its metadata: every environment has its own.
        self.metadata: dict[str, Any] = dict(AbstractEnv.metadata)
        taken = parts_of(self, with_detector(perception, parts))
        self.motion = Motion.named(taken.motion)
        self.reacting = reacting_of(traffic)
        """Which vehicles react."""
        self.duration = number("duration", duration, 0.5, 30.0)
        self._scenarios = checked_scenarios(taken.scenarios)
        self._perception, self.planner = perception_of(perception, taken)
        check_sensing(perception, taken)
        self.handover = checked_handover(handover, perception, taken.validator)
        """Seconds that the car stands by alarms until the drive ends; inf: that ends none."""
        size = checked_size(frame_size)
        if one_of("observation", observation, (FEATURES, FRAME)) == FRAME:
            config = observing_frames(config, size, sensors_read(perception, taken))
        self._scenes: LoopScenes | None = None
        self.has_usual_config = config is None
        """Whether highway-env's configuration is the default of this environment."""
        self.unread_until = 0.0
        """Seconds since the start before which no belief is read; drivers set it for one step.

        A perception that is `frame_by_frame` leaves such frames out."""
        self._ready = False
        self.intention = Intention.STRAIGHT
        super().__init__(config=config, render_mode=render_mode)
        self._ready = True

    @classmethod
    def default_config(cls) -> dict[str, Any]:
        """highway-env's configuration of this environment."""
        return {
            **AbstractEnv.default_config(),
            "observation": {"type": "Driver", "objects": 16},
            "action": {
                "type": "ContinuousAction",
                "acceleration_range": [-8.0, 8.0],
                "steering_range": [-math.pi / 4, math.pi / 4],
            },
            "simulation_frequency": 20,
            "policy_frequency": 10,
            "neighbour_vehicles_connected_lanes": True,
            # Roads lead anywhere, not along the screen alone.
            "screen_width": 600,
            "screen_height": 600,
            "centering_position": [0.5, 0.5],
        }

    def configure(self, config: Mapping[str, Any] | None) -> None:
        """Change the configuration.

        Raises:
            ConfigurationError: It is no dictionary, highway-env has no such key, or a frequency is
                no whole number of hertz; there are no more decisions than simulated steps.
        """
        if config is not None and not isinstance(config, Mapping):
            raise ConfigurationError(
                f"config is a dictionary such as {{'policy_frequency': 5}}, got {config!r}"
            )
        for name in config or {}:
            if name not in self.config:
                problem = f"highway-env's configuration has no {name!r}"
                raise ConfigurationError(unknown_name(problem, str(name), self.config))
        asked = {**self.config, **(config or {})}
        fastest = whole_number("simulation_frequency", asked["simulation_frequency"], 1, 1000)
        whole_number("policy_frequency", asked["policy_frequency"], 1, fastest)
        super().configure(None if config is None else dict(config))

    def define_spaces(self) -> None:
        """Observation and action by the configuration; observations show the belief."""
        self.observation_type = observation_of(self, self.config["observation"])
        self.action_type = action_of(self, self.config["action"])
        self.observation_space = self.observation_type.space()
        # An equal action space stays the same object, which may have been seeded.
        action_space = self.action_type.space()
        if getattr(self, "action_space", None) != action_space:
            self.action_space: gym.spaces.Space[Any] = action_space

    @property
    def scenes(self) -> LoopScenes:
        """The scenes to drive in, read when they are first needed."""
        if self._scenes is None:
            live = isinstance(self._scenarios, LoopScenes)
            self._scenes = self._scenarios if live else loop_scenes(**self._scenarios)
        return self._scenes

    @property
    def has_sensors(self) -> bool:
        """Whether the car believes what its sensors show."""
        return callable(self._perception) or isinstance(self._perception, SensorPerception)

    @property
    def perception(self) -> DrivePerception:
        """The car's perception, made when it is first needed."""
        if callable(self._perception):
            self._perception = self._perception()
        made: DrivePerception = self._perception
        return made

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin a drive; see the class for the options.

        Raises:
            ConfigurationError: There is no such scene, or it has no lane for the intention.
        """
        if not self._ready:  # highway-env resets when it is made; no scene is read for that.
            return None, {}
        self._options = reset_options(options, "config")
        return super().reset(seed=seed, options=self._options)

    def _reset(self) -> None:
        """Choose a scene, build its road, and put car and traffic on it."""
        self.scene, self.intention = self.scenes.draw(
            self.np_random,
            self._options.get("scenario"),
            intentions_named(self._options.get("intention")),
        )
        if isinstance(self.perception, SensorPerception):
            self.scene = sensing(self.scene, self.perception.needs)
        network = network_of(self.scene.lanes, speed_limit=self.scene.cruise[1])
        self.road = LoopRoad(
            network=network,
            np_random=self.np_random,
            record_history=self.config["show_trajectories"],
        )
        car = car_on_road(self.scene, self.road, self.config["action"])
        self.vehicle = car
        self.road.vehicles = [car]
        self.traffic = RoadTraffic(self.scene, self.road, self.reacting)
        self._recorder = DriveRecorder(
            self.traffic,
            self.intention,
            self.state,
            dt=1.0 / self.config["simulation_frequency"],
            duration=self.duration,
        )
        self._elapsed = 0
        self._progress = self._before = self._stood = 0.0
        self._alarms = 0
        self.perception.begin(int(self.np_random.integers(2**31)))
        self.unread_until = 0.0
        self._perceive()

    @property
    def drive(self) -> RoadTraffic:
        """What each reset makes anew, and with it the drive."""
        return self.traffic

    @property
    def controls(self) -> tuple[float, float]:
        """Acceleration, m/s2, and steering angle, radians to the left, that were asked for last."""
        acting = self.vehicle.action
        return float(acting["acceleration"]), mirrored_angle(float(acting["steering"]))

    @property
    def action_ranges(self) -> tuple[tuple[float, float], tuple[float, float]] | None:
        """What actions from -1 to 1 stand for, m/s2 and radians to the right.

        None: the actions are others.
        """
        if self.config["action"]["type"] != "ContinuousAction":
            return None
        return self.action_type.acceleration_range, self.action_type.steering_range

    @property
    def outcome(self) -> Outcome | None:
        """How the drive ended; None: it goes on."""
        return self._recorder.outcome

    @property
    def record(self) -> DriveRecord | None:
        """Metrics of the drive; None: it goes on."""
        return self._recorder.record

    @property
    def state(self) -> EgoState:
        """The car's state in this project's plane: y and angles to the left."""
        car = self.vehicle
        return EgoState(
            float(car.position[0]),
            -float(car.position[1]),
            float(car.speed),
            mirrored_angle(float(car.heading)),
            mirrored_angle(float(car.steering_angle)),
        )

    @property
    def elapsed(self) -> float:
        """Seconds since the start of the drive."""
        return self._elapsed / float(self.config["simulation_frequency"])

    @property
    def remaining(self) -> tuple[float, float]:
        """Metres to the goal, and the share of the time that is left."""
        return self._recorder.goal_distance - self._progress, 1.0 - self.elapsed / self.duration

    def surroundings(self) -> Surroundings:
        """The truth at this instant."""
        return self.traffic.around(self.state, self.elapsed, self.intention)

    def _perceive(self) -> None:
        unread, self.unread_until = self.elapsed < self.unread_until - 1e-6, 0.0
        if unread and getattr(self.perception, "frame_by_frame", False):
            return
        surroundings = self.surroundings()
        perceived = self.perception.perceive(surroundings)
        self.belief: Belief = belief_of(perceived, surroundings, self.motion)
        self._alarms += self.belief.alarm

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Drive on for a tenth of a second.

        Raises:
            ResetNeeded: There was no reset before.
            ConfigurationError: The action does not fit the space, or is not finite.
        """
        if self.road is None:
            raise gym.error.ResetNeeded("call reset before step")
        observation, reward, terminated, truncated, info = super().step(
            checked_driving(action, self.action_space)
        )
        return observation, float(reward), bool(terminated), bool(truncated), info

    def _simulate(self, action: Any = None) -> None:
        """Simulate until the next action, or until the car touches something."""
        frequency = self.config["simulation_frequency"]
        frames = int(frequency // self.config["policy_frequency"])
        self._before = self._progress
        for frame in range(frames):
            if frame == 0 and action is not None and not self.config["manual_control"]:
                self.action_type.act(action)
            self.road.act()
            self.traffic.step_absent(1.0 / frequency)
            self.road.step(1.0 / frequency)
            self.steps += 1
            self._elapsed += 1
            self.traffic.show(self.elapsed)
            self._recorder.note(self.state)
            if self.outcome is not None:
                break
            if frame < frames - 1:
                self._automatic_rendering()
        self.enable_auto_render = False
        self.vehicle.crashed |= self.outcome == Outcome.COLLISION
        self._progress = self._recorder.progress(self.state)
        # A car that stands by alarms is handed over to a human at some time.
        stands = self.belief.stops and abs(self.vehicle.speed) <= STANDING
        self._stood = self._stood + frames / frequency if stands else 0.0
        handed_over = stands and self._stood >= self.handover - 1e-9
        self._recorder.close(self.elapsed, handed_over=handed_over)
        self._perceive()

    def log(self) -> DriveLog:
        """What happened so far."""
        return self._recorder.log()

    def _rewards(self, action: Any) -> dict[str, float]:
        return {
            "progress": (self._progress - self._before) / self._recorder.goal_distance,
            "goal": float(self.outcome == Outcome.GOAL),
            "collision": -float(self.outcome == Outcome.COLLISION),
            "off_road": -float(self.outcome == Outcome.OFF_ROAD),
        }

    def _reward(self, action: Any) -> float:
        return float(sum(self._rewards(action).values()))

    def _is_terminated(self) -> bool:
        return self.outcome in (Outcome.GOAL, Outcome.COLLISION, Outcome.OFF_ROAD)

    def _is_truncated(self) -> bool:
        return self.outcome in (Outcome.STOPPED, Outcome.TIME)

    def _info(self, obs: Any, action: Any = None) -> dict[str, Any]:
        so_far = SoFar(self.elapsed, self._recorder.path_length, self._progress)
        return {
            **drive_info(self.record, self.scene.id, str(self.intention), so_far),
            "speed": float(self.vehicle.speed),
            "crashed": bool(self.vehicle.crashed),
            "alarm": self.belief.alarm,
            "alarms": self._alarms,
        }
