"""The parts of the driving car, checked when the environment is made."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from avsec_gym.argument_checks import number, one_of
from avsec_gym.attacks.facula import Facula
from avsec_gym.attacks.optical_attack import OpticalAttack, check_attacked, check_there
from avsec_gym.closed_loop.error_model.model import ErrorModel
from avsec_gym.closed_loop.error_model.perception import ErrorModelPerception
from avsec_gym.closed_loop.light.beliefs import LightBlindness, LightPerception, LightTruth
from avsec_gym.closed_loop.light.light_errors import LightErrors
from avsec_gym.closed_loop.loop_scenes import (
    DRIVES,
    NAMED,
    LoopScenes,
    loop_scenes,
    scenes_to_drive_in,
)
from avsec_gym.closed_loop.perception import (
    BlindPerception,
    DrivePerception,
    SensorPerception,
    TruthPerception,
)
from avsec_gym.closed_loop.sensor_needs import SensorNeeds, width_read
from avsec_gym.envs.game_validator import judges_by_others
from avsec_gym.envs.one_thread import one_thread
from avsec_gym.envs.parts import Parts
from avsec_gym.errors import ConfigurationError
from avsec_gym.pipeline import Pipeline
from avsec_gym.registry import Kind, check, make
from avsec_gym.rig import KITTI_SIZE
from avsec_gym.scenario.scene import Motion
from avsec_gym.scenario.scene_arguments import scene_arguments
from avsec_gym.scenario.scene_set import SceneSet
from avsec_gym.scenario.scene_sets import LAYOUTS
from avsec_gym.sensor_system import Sensor
from avsec_gym.storage.regular_files import is_folder
from avsec_gym.suggestions import unknown_name
from avsec_gym.unknown_source import unknown_source

TRUTH, BLIND, SENSORS, ERROR_MODEL = "truth", "blind", "sensors", "error_model"
LIDAR, STEREO = "lidar", "stereo"
"""Levels of perception."""
SENSING = (SENSORS, LIDAR, STEREO)
"""The perceptions that read what the sensors deliver."""
_DETECTORS = {LIDAR: "pixor", STEREO: "dsgn"}
"""Detectors where none is named."""
_SENSING_PARTS = (
    "attack",
    "classifier",
    "selector",
    "validator",
    "detector",
    "response",
    "score_threshold",
)
"""Parts that work on what sensors deliver, or on what is detected in it."""

Made = DrivePerception | Callable[[], DrivePerception]


def checked_scenarios(what: Any) -> Any:
    """The scenes of a folder, or the arguments that `loop_scenes` makes procedural ones of.

    Args:
        what: A name, a folder, a dictionary of arguments; a `SceneSet`, or live scenes to drive in.

    Raises:
        ConfigurationError: These are no such arguments.
        DataError: There is no such folder, or it holds no scene.
    """
    if isinstance(what, LoopScenes):
        return what
    if isinstance(what, SceneSet):
        return scenes_to_drive_in(what)
    people = True
    if isinstance(what, Mapping) and "people" in what:
        people = what["people"]
        if not isinstance(people, bool):
            raise ConfigurationError(f"people is true or false, got {people!r}")
        what = {name: value for name, value in what.items() if name != "people"}
    arguments = scene_arguments(what, loop_scenes)
    source = str(arguments.get("source", DRIVES))
    if source not in NAMED and not is_folder(Path(source)) and "kitti" not in arguments:
        raise unknown_source(
            source,
            NAMED,
            f"Name a folder of labels or of CommonRoad files, or {', '.join(map(repr, NAMED))}.",
        )
    arguments["people"] = people
    # What procedural scenes are made of is known; folders are read at once, as they may be broken.
    return arguments if source in (LAYOUTS, DRIVES) else loop_scenes(**arguments)


def with_detector(perception: Any, parts: Mapping[str, Any]) -> dict[str, Any]:
    """The parts that a user gave, the usual detector of the level, and motion by a classifier.

    Args:
        perception: The level.
        parts: The keyword arguments.
    """
    level = perception.get("name") if isinstance(perception, Mapping) else perception
    usual: dict[str, Any] = {}
    if isinstance(level, str) and level in _DETECTORS:
        usual["detector"] = _DETECTORS[level]
    if parts.get("classifier") is not None:
        usual["motion"] = Motion.CLASSIFIER
    return {**usual, **parts}


def perception_of(perception: Any, parts: Parts) -> tuple[Made, Any]:
    """The perception, or what makes it when it is needed, and the planner; both checked.

    Args:
        perception: A level, or a live `DrivePerception`.
        parts: The parts of the car.

    Raises:
        ConfigurationError: A name is unknown, thresholds have no table, or a part is named that
            this perception would never ask.
    """
    with one_thread():
        planner = make(Kind.PLANNER, parts.planner)
    if parts.validator is not None:
        check(Kind.VALIDATOR, parts.validator)
    # A dictionary: a level with its arguments, or an error model, which is live at once.
    if isinstance(perception, Mapping):
        perception = _level(perception)
    if isinstance(perception, str) and perception == ERROR_MODEL:
        raise ConfigurationError(
            'perception by an error model names it: {"name": "error_model", "model": MODEL}, a'
            " shipped one, such as stereo_rcnn, or a file that `avsec error-model fit` makes"
        )
    if not isinstance(perception, str):
        if not (hasattr(perception, "perceive") and hasattr(perception, "begin")):
            raise ConfigurationError(
                f'perception is "{TRUTH}", "{BLIND}", "{LIDAR}", "{STEREO}", "{SENSORS}", an error '
                f"model, or has begin and perceive; got {perception!r}"
            )
        if isinstance(perception, ErrorModelPerception):
            _refuse_unasked(parts, "perception by an error model")
        else:  # It may have classified what moves, and respond to alarms of its own.
            own = replace(parts, classifier=None, motion=Motion.STATIC, response=Parts.response)
            _refuse_unasked(own, "a live perception")
        return perception, planner
    # A level: what does not sense asks no part; what does is made when it is needed.
    level = one_of("perception", perception, (TRUTH, BLIND, *SENSING))
    if level not in SENSING:
        _refuse_unasked(parts, f'perception="{level}"')
    if parts.motion == Motion.CLASSIFIER and level not in (SENSORS, STEREO):
        raise ConfigurationError(
            'a classifier, and motion="classifier", need images: perception="sensors" or "stereo"; '
            'for others use motion="static" or "truth"'
        )
    if parts.classifier is not None and parts.motion != Motion.CLASSIFIER:
        raise ConfigurationError(
            f'motion="{parts.motion}" would leave the classifier unheard: leave one of them out'
        )
    if level not in SENSING:
        return (TruthPerception() if level == TRUTH else BlindPerception()), planner

    needs = _needs(level, parts)

    def sensors() -> DrivePerception:
        with one_thread():
            pipeline = Pipeline(
                parts.detector,
                attack=parts.attack,
                classifier=parts.classifier,
                selector=parts.selector,
                planner=planner,
                score_threshold=parts.score_threshold,
                validator=parts.validator,
                response=parts.response,
            )
        width = width_read(pipeline.detector) if not needs.scan else None
        if width is not None and isinstance(pipeline.attack, OpticalAttack):
            # Light is placed by the pixels of a camera's own image: it goes with them.
            if isinstance(pipeline.attack, Facula):
                pipeline = replace(pipeline, attack=_reduced(pipeline.attack, width))
            else:
                width = None
        return SensorPerception(pipeline, replace(needs, width=width))

    return sensors, planner


def check_sensing(perception: Any, parts: Parts, attacked: frozenset[Sensor] = frozenset()) -> None:
    """Refuse to read sensors that the scenes do not have, and to attack those that are not read.

    Args:
        perception: A level, or a live `DrivePerception`, which is left to itself.
        parts: The parts of the car, as `perception_of` accepts them.
        attacked: The sensors that an agent's attack tampers with, beside that of the parts.

    Raises:
        ConfigurationError: Its drives could never begin.
    """
    level = perception.get("name") if isinstance(perception, Mapping) else perception
    if not isinstance(level, str) or level not in SENSING:
        return
    scenes = parts.scenarios
    if isinstance(scenes, LoopScenes):  # Their sensors are known when they are driven in.
        return
    source = scenes.get("source", DRIVES) if isinstance(scenes, Mapping) else scenes
    if source != DRIVES:
        raise ConfigurationError(
            f'perception="{level}" reads sensor data, which these scenes do not have: give'
            f' scenarios="{DRIVES}", or perception="{TRUTH}"'
        )
    read, where = _needs(level, parts).sensors, f'drives with perception="{level}"'
    check_attacked(parts.attack, read, where)
    check_there("the agent's attack", attacked, read, where)


def checked_handover(handover: float | None, perception: Any, validator: Any) -> float:
    """The seconds of a handover; inf without one.

    Args:
        handover: What was given.
        perception: A level, or a live `DrivePerception`, which may stop the car by itself.
        validator: The validator; None: there is none.

    Raises:
        ConfigurationError: They are no number of seconds, or nothing can raise an alarm.
    """
    if handover is None:
        return math.inf
    if validator is None and isinstance(perception, str | Mapping):
        raise ConfigurationError(
            "handover counts how long the car stands by alarms: name a validator, which raises them"
        )
    return number("handover", handover, 0.1, 30.0)


def sensors_read(perception: Any, parts: Parts) -> frozenset[Sensor]:
    """The sensors whose data a perception reads; none where it needs no frame.

    Args:
        perception: A level, or a live `DrivePerception`.
        parts: The parts of the car, as `perception_of` accepts them.
    """
    if isinstance(perception, SensorPerception):
        return perception.needs.sensors
    level = perception.get("name") if isinstance(perception, Mapping) else perception
    reads = isinstance(level, str) and level in SENSING
    return _needs(str(level), parts).sensors if reads else frozenset()


def _refuse_unasked(parts: Parts, perception: str) -> None:
    """Refuse parts of cars with sensors where none is asked for."""
    if named := [name for name in _SENSING_PARTS if getattr(parts, name) != getattr(Parts, name)]:
        raise ConfigurationError(
            f"with {perception}, {' and '.join(named)} would never be asked: give "
            f'perception="{SENSORS}", or leave out what is not to be asked'
        )


def _needs(level: str, parts: Parts) -> SensorNeeds:
    """What a level reads; a validator compares all sensors, as they are, or the LiDAR alone."""
    connected = parts.validator is not None and judges_by_others(parts.validator)
    # Attacks on a LiDAR that a validator judges are placed in a camera's view.
    aimed = connected and parts.attack is not None
    if level == SENSORS or aimed or (parts.validator is not None and not connected):
        return SensorNeeds()
    return SensorNeeds(cameras=()) if level == LIDAR else SensorNeeds(scan=connected)


def light_perceptions(made: Made, motion: Motion, count: int) -> list[LightPerception]:
    """The perceptions of many light drives, one for each.

    Args:
        made: What `perception_of` made.
        motion: What the planner knows of motion.
        count: Number of drives.

    Raises:
        ConfigurationError: It is one that only a single environment has.
    """
    if motion == Motion.CLASSIFIER:
        raise ConfigurationError(
            'many drives at once have no classifier: give motion="static" or "truth"'
        )
    moving = motion == Motion.TRUTH
    kinds: dict[type, Callable[[], LightPerception]] = {
        TruthPerception: lambda: LightTruth(moving),
        BlindPerception: LightBlindness,
        ErrorModelPerception: lambda: LightErrors(made.model, moving),  # type: ignore[union-attr]
    }
    if type(made) not in kinds:
        raise ConfigurationError(
            f'many drives at once perceive by "{TRUTH}", "{BLIND}" or an error model; for other '
            'perception make single environments: gym.make_vec(..., vectorization_mode="sync")'
        )
    return [kinds[type(made)]() for _ in range(count)]


def _reduced(attack: Facula, width: int) -> Facula:
    """The same light in images of another width; its radius is that of a wide one in any case."""
    if attack.centre is None:
        return attack
    share = min(width / KITTI_SIZE[0], 1.0)  # None are rendered wider than the camera's own.
    u, v = attack.centre
    return replace(attack, centre=(share * u, share * v))


def _level(given: Mapping[str, Any]) -> str | DrivePerception:
    """The level in a dictionary; an error model alone has an argument, its name or file.

    Raises:
        ConfigurationError: It has no name, or arguments that the level does not have.
        DataError: The error model is missing or damaged.
    """
    known = ["name", "model"] if given.get("name") == ERROR_MODEL else ["name"]
    for name in given:
        if name not in known:
            problem = f"perception has no {name!r}"
            raise ConfigurationError(unknown_name(problem, str(name), known))
    if not isinstance(given.get("name"), str):
        raise ConfigurationError(f"perception as a dictionary needs a 'name', got {dict(given)!r}")
    if "model" not in given:
        return str(given["name"])
    if not isinstance(given["model"], str | Path | ErrorModel):
        raise ConfigurationError(f"the error model is a name or a file, got {given['model']!r}")
    return ErrorModelPerception(given["model"])
