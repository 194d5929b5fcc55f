"""`avsec/SensorIdentification-v0`: a validator that names the attacked sensors."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from avsec_gym.argument_checks import number, shown, whole_number
from avsec_gym.attacks.sensor_combination import attack_cases, thesis_attack
from avsec_gym.envs.actions import checked_flags
from avsec_gym.envs.info import drive_info
from avsec_gym.envs.rendering import DrawnEnv
from avsec_gym.envs.reset_options import reset_options
from avsec_gym.errors import ConfigurationError
from avsec_gym.frame import SensorFrame
from avsec_gym.kitti.raw import KittiRaw
from avsec_gym.scenario.intention import Intention, intentions_named
from avsec_gym.sensor_system import KITTI_SYSTEM, Sensor, SensorSystem
from avsec_gym.storage.regular_files import is_folder
from avsec_gym.suggestions import unknown_name
from avsec_gym.unknown_source import unknown_source
from avsec_gym.validation.evidence.disparity_error import DisparityErrors
from avsec_gym.validation.evidence.disparity_maps import DisparityMaps
from avsec_gym.validation.evidence.evidence import evidence_scopes, gather_evidence
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.recordings import RecordedFrame, raw_recordings
from avsec_gym.validation.state_posterior import SensorStatus
from avsec_gym.validation.validator import Validation

Observation = NDArray[np.float32]
_ARGUMENTS = ("source", "first", "count")
"""Of what is played."""


class SensorIdentificationEnv(DrawnEnv[Observation]):
    """Name the sensors of a car that are attacked, from how far they contradict each other.

    ## Description
    A car has a LiDAR and several cameras.  In some frames an attacker shines a laser into some of
    the cameras, or fires bogus returns into the LiDAR (the thesis' attacks, section 3.2.4).  The
    agent is the validator: it sees how far the sensors contradict each other, and names those that
    are attacked.  `ValidatorPolicy` makes any validator of this project an agent, so that
    `evaluate_policy` of stable-baselines3 ranks them, and trained ones beside them.  No car drives
    here.

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
    (attacked, not named), `false_alarms` (named, not attacked), `scenario` (the frame's id).  As
    in every environment there are `planned`, `collision`, `safe`, `cost` (0), `outcome` (`reset`,
    then `unplanned`) and `intention`; since no car drives, they mean nothing here.

    ## Arguments
    * `scenarios="raw"`: the default suite of drives of the procedural world, made in the cache on
      first use; a drive, a day of drives or a folder of days in KITTI's raw layout; or a dictionary
      such as `{"source": "raw", "first": 0, "count": 20}`, to train and to judge on different ones.
    * `sensors=("lidar", 1, 3, 2)`: S_0 to S_n, the LiDAR, if any, then cameras from right to left.
    * `depth="sgbm"`: how disparities of two cameras are found; a name or a dictionary.
    * `clean=0.5`: share of the episodes without an attack; in the others, every set of attacked
      sensors is as likely.
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
        scenarios: Any = "raw",
        sensors: tuple[Sensor, ...] = KITTI_SYSTEM.sensors,
        depth: Any = "sgbm",
        clean: float = 0.5,
        most: int | None = None,
        render_mode: str | None = None,
    ) -> None:
        super().__init__(render_mode)
        self.system, self.depth = SensorSystem(sensors), PairDepth(depth)
        count = len(self.system)
        most = max(1, count - 3) if most is None else whole_number("most", most, 1, count)
        self.clean, self.cases = number("clean", clean, 0.0, 1.0), attack_cases(self.system, most)
        self._played = _played(scenarios)
        size = len(evidence_scopes(self.system))
        self.observation_space = gym.spaces.Box(0.0, 1.0, (size,), np.float32)
        self.action_space = gym.spaces.MultiBinary(count)  # type: ignore[assignment]
        self._recorded: RecordedFrame | None = None
        self._intention = Intention.STRAIGHT
        self._frame: SensorFrame | None = None
        self._errors: DisparityErrors | None = None
        self._attacked = np.zeros(count, bool)
        self._named: NDArray[np.bool_] | None = None

    @cached_property
    def frames(self) -> tuple[RecordedFrame, ...]:
        """The recorded frames that are played, without an attack.

        Raises:
            ConfigurationError: There are fewer frames than `first` leaves out.
            DataError: There is none, or it lacks a sensor.
        """
        source, first, count = self._played
        if source == "raw":
            from avsec_gym.world.export import default_suite

            source = default_suite("raw")
        every = raw_recordings(source, self.system.sensors).frames
        chosen = every[first:][:count]
        if not chosen:
            raise ConfigurationError(f"of {len(every)} frames, none is left from {first} on")
        return chosen

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
        self._intention = intentions[int(random.integers(len(intentions)))]
        self._recorded = self._picked(options.get("scenario"))
        drawn = self.cases[int(random.integers(len(self.cases)))]
        attacked = drawn if random.random() >= self.clean else ()
        if "attacked" in options:
            attacked = self._chosen(options["attacked"])
        self._attacked = np.array([sensor in attacked for sensor in self.system.sensors])
        attack = thesis_attack(attacked, self.system.reference)
        self._frame = attack.attack(self._recorded.frame(), int(random.integers(2**31))).frame
        self._errors = DisparityErrors(DisparityMaps(self._frame, self.system, self.depth))
        self._named = None
        self.shown()
        return self._observe(), self._info()

    def step(self, action: NDArray[Any]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Compare with what was attacked; the episode is over."""
        _ = self.frame
        self._named = checked_flags(action, len(self.system))
        self.shown()
        info = self._info()
        return self._observe(), float(info["is_success"]), True, False, info

    def picture(self) -> NDArray[np.uint8] | None:
        """The sensors with their status, beside where they contradict each other."""
        if self._errors is None:
            return None
        from avsec_gym.drawing.scenario_picture import picture_array
        from avsec_gym.drawing.validation_picture import draw_validation

        flags = np.zeros(len(self.system), bool) if self._named is None else self._named
        status = [SensorStatus.ATTACKED if flag else SensorStatus.SOUND for flag in flags]
        if self._named is None:
            status = [SensorStatus.CANNOT_TELL] * len(status)
        of_sensors = dict(zip(self.system.sensors, status, strict=True))
        validation = Validation(bool(flags.any()), of_sensors, self._errors)
        return picture_array(draw_validation(validation))

    def _picked(self, id: Any) -> RecordedFrame:
        if id is None:
            return self.frames[int(self.np_random.integers(len(self.frames)))]
        for recorded in self.frames:
            if recorded.id == str(id):
                return recorded
        raise ConfigurationError(f"there is no frame {id!r}; the first is {self.frames[0].id!r}")

    def _chosen(self, attacked: Any) -> tuple[Sensor, ...]:
        """The sensors that a user wants attacked."""
        known = self.system.sensors
        if not isinstance(attacked, list | tuple) or any(each not in known for each in attacked):
            raise ConfigurationError(
                f"attacked is a list of sensors, such as [{known[-1]!r}], of "
                f"{', '.join(map(str, known))}, got {shown(attacked)}"
            )
        return tuple(attacked)

    def _observe(self) -> Observation:
        assert self._errors is not None
        return gather_evidence(self._errors, threads=1).astype(np.float32)

    def _info(self) -> dict[str, Any]:
        assert self._recorded is not None
        over, named = self._named is not None, self._named
        named = np.zeros_like(self._attacked) if named is None else named
        attacked = self._attacked & over
        drive = drive_info(None, self._recorded.id, self._intention)
        return {
            **drive,
            # Not nan, which Gymnasium's checker takes for another value every time.
            **dict.fromkeys(("cost", "path_length", "smallest_distance", "cost_sm1"), 0.0),
            "outcome": "unplanned" if over else drive["outcome"],
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


def _played(what: Any) -> tuple[str | Path, int, int | None]:
    """Where the frames are, from which one on, and how many; none is read.

    Raises:
        ConfigurationError: The arguments name no recording.
        DataError: There is no such folder, or it has another layout.
    """
    given = what if isinstance(what, Mapping) else {"source": what}
    for name in given:
        if name not in _ARGUMENTS:
            problem = f"frames are named by source, first and count, not by {shown(name)}"
            raise ConfigurationError(unknown_name(problem, str(name), _ARGUMENTS))
    first = whole_number("first", given.get("first", 0), 0)
    count = None if given.get("count") is None else whole_number("count", given["count"], 1)
    source = given.get("source", "raw")
    if not isinstance(source, str | Path):
        raise ConfigurationError(
            f"scenarios are a folder in KITTI's raw layout, or 'raw', got {shown(source)}"
        )
    if source != "raw":
        if not is_folder(source):
            expected = "Name a folder in KITTI's raw layout, or 'raw'."
            raise unknown_source(str(source), ["raw"], expected)
        KittiRaw(source)  # Refuses a folder of another layout.
    return source, first, count
