"""`avsec/SensorIdentification-v0`: a validator that names the attacked sensors."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import number, shown, whole_number
from avsec_gym.attacks.optical_attack import OpticalAttack, check_attacked
from avsec_gym.attacks.sensor_combination import attack_cases, thesis_attack
from avsec_gym.envs.actions import checked_flags
from avsec_gym.envs.identification_frames import (
    PlayedFrame,
    has_scenes,
    played_frames,
    usual_sensors,
)
from avsec_gym.envs.info import episode_info
from avsec_gym.envs.one_thread import one_thread
from avsec_gym.envs.parts import Parts, parts_of, takes_parts
from avsec_gym.envs.rendering import DrawnEnv
from avsec_gym.envs.reset_options import reset_options
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.pipeline import Episode, Pipeline
from avsec_gym.registry import Kind
from avsec_gym.scenario.intention import Intention, intentions_named
from avsec_gym.sensor_system import Sensor, SensorSystem
from avsec_gym.validation.evidence.disparity_error import DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.evidence.evidence import evidence_scopes, gather_evidence
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.validation.validator import Validation

Observation = NDArray[np.float32]
_THESIS = "thesis"
"""The default attack, on sensors that are drawn."""
_OF_A_CAR = (
    "detector",
    "classifier",
    "selector",
    "planner",
    "response",
    "motion",
    "score_threshold",
)
"""Parts that drive in labelled scenes alone."""


@takes_parts(
    Kind.VALIDATOR,
    refused={
        "validator": "the agent plays it",
        "clean": "no thresholds are measured; `unattacked` is the share of episodes without an "
        "attack",
    },
    scenarios="raw",
    attack=_THESIS,
)
class SensorIdentificationEnv(DrawnEnv[Observation]):
    """Name the sensors of a car that are attacked, from how far they contradict each other.

    **Naming no sensor wins half of the episodes.**  By default 50 % of them have no attack
    (`unattacked=0.5`), and there this constant answer is right; it is right in no other.  A
    validator is to be held against that figure; `unattacked=0` leaves the constant nothing.

    ## Description
    A car has a LiDAR and several cameras.  In some frames an attacker shines a laser into some of
    the cameras, or fires bogus returns into the LiDAR (the thesis' attacks, section 3.2.4).  The
    agent is the validator: it sees how far the sensors contradict each other, and names those that
    are attacked.  `ValidatorPolicy` makes any validator of this project an agent, so that
    `evaluate_policy` of stable-baselines3 ranks them, and trained ones beside them.  In labelled
    scenes the rest of the car drives on the agent's answer, as `response` states, so that a
    validator is judged by what it saves too; in recorded drives no car drives.

    ## Observation
    `Box(0, 1, (E,), float32)`: how far the sensors contradict each other, shares from 0 to 1: of
    every triple of sensors i < j < k the disparity error E_{i,j,k}, and with the LiDAR where most
    of its points are disproved; of every pair of cameras i < k the share of the view without depth,
    and those in which k sees brighter or darker than i.
    `avsec_gym.validation.evidence.evidence.evidence_elements` lists what each element is.  With a
    LiDAR and three cameras E is 16.

    ## Action
    `MultiBinary(n + 1)`: for each sensor, in the order of `sensors`, whether it is attacked.

    ## Reward
    1 if the attacked sensors are named exactly, none where none is; else 0.

    ## Episode end
    Terminated after one step.

    ## Info
    `is_success` (named exactly), `attacked` and `named` (sensors, such as `"lidar 3"`, in the order
    of `sensors`; empty at reset, and where there are none), `hits` (attacked and named), `missed`
    (attacked, not named), `false_alarms` (named, not attacked).  As in every environment,
    `planned`, `success`, `collision`, `safe`, `cost`, `path_length`, `smallest_distance`,
    `cost_sm1`, `outcome`, `scenario` (the frame's id), `intention`: see
    `avsec_gym.envs.info.episode_info`.  In recorded drives, where no car drives, the numbers are 0
    and the outcome is `unplanned`.

    ## Arguments
    * `scenarios="raw"`: the default suite of drives of the procedural world, made in the cache on
      first use; a drive, a day of drives or a folder of days in KITTI's raw layout; a dictionary
      such as `{"source": "raw", "first": 0, "count": 20}`, to train and to judge on different ones;
      or labelled scenes with scans, named as in the other environments: `"mixed"`, a folder in
      KITTI's object layout.
    * The other parts, but for `validator` and `clean`, see `avsec_gym.envs.parts.Parts`; they drive
      in labelled scenes, and are refused elsewhere.  `attack="thesis"`: the thesis' attacks on
      sensors that are drawn; or an optical attack, such as `{"name": "facula", "camera": 2}`; None:
      no attack.
    * `sensors=None`: S_0 to S_n, the LiDAR, if any, then cameras from right to left; None:
      `("lidar", 1, 3, 2)` in drives, `("lidar", 3, 2)` in labelled scenes.
    * `depth="sgbm"`: how disparities of two cameras are found; a name or a dictionary.
    * `unattacked=0.5`: share of the episodes without an attack; in the others, every set of
      attacked sensors is as likely.
    * `most=None`: sensors attacked at once; None: n - 2, which is as many as the thesis' algorithms
      can name.
    * `render_mode`: None, `"rgb_array"` or `"human"` (needs the extra `view`).

    `reset(options={"scenario": id, "attacked": ["lidar", 3]})` picks a frame, and an attack;
    `[]` is none.

    ## Versions
    * v0: first.
    """

    title = "avsec/SensorIdentification-v0"

    def __init__(
        self,
        *,
        sensors: tuple[Sensor, ...] | None = None,
        depth: Any = "sgbm",
        unattacked: float = 0.5,
        most: int | None = None,
        render_mode: str | None = None,
        **parts: Any,
    ) -> None:
        super().__init__(render_mode)
        # The thesis' attacks are drawn for each episode; any other one is made now.
        attack = parts.get("attack", _THESIS)
        self._drawn = isinstance(attack, str) and attack == _THESIS
        self.parts = parts_of(self, {**parts, "attack": None} if self._drawn else parts)
        self._check_driven()
        self._attack = _optical(self.parts.attack)
        usual = usual_sensors(self.parts.scenarios, self.parts.road)
        self.system = SensorSystem(usual if sensors is None else sensors)
        # The agent could not name another sensor.
        check_attacked(self._attack, self.system.sensors, "the sensors that are judged")
        self.depth = PairDepth(depth)
        count = len(self.system)
        most = max(1, count - 3) if most is None else whole_number("most", most, 1, count)
        self.unattacked = number("unattacked", unattacked, 0.0, 1.0)
        self.cases = attack_cases(self.system, most)
        size = len(evidence_scopes(self.system))
        self.observation_space = gym.spaces.Box(0.0, 1.0, (size,), np.float32)
        self.action_space = gym.spaces.MultiBinary(count)  # type: ignore[assignment]
        self._played: PlayedFrame | None = None
        self._intention = Intention.STRAIGHT
        self._frame: SensorFrame | None = None
        self._errors: DisparityErrors | None = None
        self._attacked = np.zeros(count, bool)
        self._named: NDArray[np.bool_] | None = None
        self._episode: Episode | None = None

    def _check_driven(self) -> None:
        """Refuse parts of a car where none drives.

        Raises:
            ConfigurationError: The frames are of recordings, and something drives by a part.
        """
        named = [name for name in _OF_A_CAR if getattr(self.parts, name) != getattr(Parts, name)]
        if named and not has_scenes(self.parts.scenarios, self.parts.road):
            raise ConfigurationError(
                f"no car drives in recordings, and {' and '.join(named)} would never be asked: "
                'give labelled scenes, such as scenarios="mixed", or leave out what is not asked'
            )

    @cached_property
    def frames(self) -> tuple[PlayedFrame, ...]:
        """The frames that are played, without an attack; see `played_frames`."""
        return played_frames(self.parts.scenarios, self.system.sensors, self.parts.road)

    @cached_property
    def pipeline(self) -> Pipeline:
        """The car, in which the agent stands for the validator.

        Raises:
            ConfigurationError: Arguments of a part do not fit.
            DataError: A file, such as the detector's weights, is missing or broken.
        """
        return self.parts.car(Named(self.system))[0]

    @property
    def frame(self) -> SensorFrame:
        """What the sensors deliver, attacked or not, for validators that need all of it.

        Raises:
            ResetNeeded: There is no frame yet.
        """
        if self._frame is None:
            raise gym.error.ResetNeeded("call reset before step")
        return self._frame

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Draw a frame and an attack; ``options`` may pick them, and an ``intention``."""
        super().reset(seed=seed)
        options = reset_options(options, "attacked")
        random, intentions = self.np_random, intentions_named(options.get("intention"))
        number = int(random.integers(len(intentions)))
        self._played = self._picked(options.get("scenario"))
        self._intention = intentions[number]
        possible = (
            intentions if self._played.scene is None else self._played.scene.possible(intentions)
        )
        # Of fewer, one is drawn anew; where all are possible a seed keeps its episodes.
        if len(possible) < len(intentions):
            self._intention = possible[int(random.integers(len(possible)))]
        drawn = self.cases[int(random.integers(len(self.cases)))]
        attacked = drawn if random.random() >= self.unattacked else ()
        if "attacked" in options:
            attacked = self._chosen(options["attacked"])
        seed = int(random.integers(2**31))
        tampered = self._attack_on(attacked).attack(self._played.frame(), seed)
        self._frame = tampered.frame
        self._attacked = np.array([s in tampered.attacked for s in self.system.sensors])
        self._errors = DisparityErrors(DisparityMaps(self._frame, self.system, self.depth))
        self._named = self._episode = None
        self.shown()
        return self._observe(), self._info()

    def step(self, action: NDArray[Any]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Compare with what was attacked, and let the car drive; the episode is over."""
        frame = self.frame
        self._named = checked_flags(action, len(self.system))
        if self._played is not None and (scene := self._played.scene) is not None:
            with one_thread():
                perception = self.pipeline.perceive(frame, self._validation())
            self._episode = self.pipeline.run_episode(scene, perception, self._intention)
        self.shown()
        info = self._info()
        return self._observe(), float(info["is_success"]), True, False, info

    def picture(self) -> NDArray[np.uint8] | None:
        """The sensors with their status, beside where they contradict each other."""
        if self._errors is None:
            return None
        from avsec_gym.drawing.scenario_picture import picture_array
        from avsec_gym.drawing.validation_picture import draw_validation

        return picture_array(draw_validation(self._validation()))

    def _validation(self) -> Validation:
        """The answer of the agent as a validator's; before it, no sensor's status is known."""
        assert self._errors is not None
        status = [SensorStatus.CANNOT_TELL] * len(self.system)
        if self._named is not None:
            status = [SensorStatus.ATTACKED if flag else SensorStatus.SOUND for flag in self._named]
        alarm = self._named is not None and bool(self._named.any())
        of_sensors = dict(zip(self.system.sensors, status, strict=True))
        return Validation(alarm, of_sensors, self._errors)

    def _attack_on(self, sensors: tuple[Sensor, ...]) -> OpticalAttack:
        """The attack of an episode: the thesis' on these sensors, or the one that was named."""
        if self._drawn or self._attack is None or not sensors:
            return thesis_attack(sensors if self._drawn else (), self.system.reference)
        return self._attack

    def _picked(self, id: Any) -> PlayedFrame:
        if id is None:
            return self.frames[int(self.np_random.integers(len(self.frames)))]
        for played in self.frames:
            if played.id == str(id):
                return played
        raise ConfigurationError(f"there is no frame {id!r}; the first is {self.frames[0].id!r}")

    def _chosen(self, attacked: Any) -> tuple[Sensor, ...]:
        """The sensors that a user wants attacked."""
        known = self.system.sensors
        if not isinstance(attacked, list | tuple) or any(each not in known for each in attacked):
            raise ConfigurationError(
                f"attacked is a list of sensors, such as [{known[-1]!r}], of "
                f"{', '.join(map(str, known))}, got {shown(attacked)}"
            )
        if not self._drawn and attacked and set(attacked) != self._fixed_sensors:
            raise ConfigurationError(
                f"the attack that was named is one on {sorted(map(str, self._fixed_sensors))}, got "
                f"attacked={shown(attacked)}: give these, or []"
            )
        return tuple(attacked)

    @property
    def _fixed_sensors(self) -> frozenset[Sensor]:
        """Those that an attack attacks which is not drawn."""
        return frozenset() if self._attack is None else self._attack.sensors

    def _observe(self) -> Observation:
        assert self._errors is not None
        return gather_evidence(self._errors, threads=1).astype(np.float32)

    def _info(self) -> dict[str, Any]:
        assert self._played is not None
        over, named = self._named is not None, self._named
        named = np.zeros_like(self._attacked) if named is None else named
        attacked = self._attacked & over
        episode = episode_info(self._episode, self._played.id, self._intention)
        if self._played.scene is None:
            # Not nan, which Gymnasium's checker takes for another value every time.
            episode |= dict.fromkeys(("cost", "path_length", "smallest_distance", "cost_sm1"), 0.0)
            episode["outcome"] = "unplanned" if over else episode["outcome"]
        return {
            **episode,
            "is_success": over and bool((named == attacked).all()),
            "attacked": self._listed(attacked),
            "named": self._listed(named),
            "hits": int((attacked & named).sum()),
            "missed": int((attacked & ~named).sum()),
            "false_alarms": int((named & ~attacked).sum()),
        }

    def _listed(self, flags: NDArray[np.bool_]) -> str:
        return " ".join(
            str(sensor) for sensor, flag in zip(self.system.sensors, flags, strict=True) if flag
        )


class Named:
    """The agent in the validator's place, whose answer the environment hands to the pipeline.

    Args:
        system: The sensors that it judges.
    """

    name = "agent"

    def __init__(self, system: SensorSystem) -> None:
        self.system = system

    def validate(self, frame: SensorFrame) -> Validation:
        """Not asked for: an agent answers before the car drives."""
        raise NotImplementedError("the agent's answer is handed to `Pipeline.perceive`")


def _optical(attack: Any) -> OpticalAttack | None:
    """The attack that was named.

    Raises:
        ConfigurationError: It attacks pixels, so that no sensor is attacked or sound.
    """
    if attack is None or isinstance(attack, OpticalAttack):
        return attack
    raise ConfigurationError(
        f"a validator names the sensors that are attacked with light, and {attack.name!r} changes "
        'what a detector sees: give an optical attack, such as {"name": "facula", "camera": 2}'
    )
