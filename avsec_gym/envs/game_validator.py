"""The validator of a game, its thresholds measured on scenes that are not played."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast, get_args

from avsec_gym.argument_checks import number, one_of
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.registry import Kind, check, make
from avsec_gym.scenario.frame_scenes import FrameScenes, check_frame_scenes
from avsec_gym.scenario.scene import Scene
from avsec_gym.sensor_system import LIDAR

if TYPE_CHECKING:  # OpenCV is loaded with the validator, not before.
    from avsec_gym.validation.thresholds import ThresholdTable
    from avsec_gym.validation.validator import Validator

CLEAN = 50
"""Scenes at most that thresholds are measured on."""
FEWEST = 10
"""Scenes at least that a game keeps back for that; whoever names scenes may name fewer."""


def validator_and_played(
    what: Any, scenes: FrameScenes, clean: FrameScenes | None = None
) -> tuple[Validator | None, FrameScenes]:
    """A validator of the LiDAR and the cameras 3 and 2, and the scenes that are left to be played.

    The scenes that a validator was fitted on show little of how often it is wrong: scenes that
    thresholds are measured on are not played.  Of N clean scenes at most rate * N lie beyond the
    thresholds, which is none of 50 at a rate of 0.01: the thresholds of few scenes are the largest
    values that these show, and a new scene lies beyond that of a share with a probability of 1 / (N
    + 1).  The scenes of a table that was measured elsewhere are not known here.

    Args:
        what: A name, a dictionary of a name and arguments, or a live one; None: no validator.
            ``thresholds`` without a table is given one that is measured on clean scenes.
        scenes: All scenes of the game.
        clean: Scenes without an attack, of which the first `CLEAN` count; None: those of the first
            half of the game's, as `avsec validate` takes the first part of a recording.  Only for
            thresholds that have no table.

    Raises:
        ConfigurationError: Nothing has that name, its arguments cannot be, half of the game's
            scenes are fewer than `FEWEST`, none is left to be played, they lack a sensor that the
            validator judges, or clean scenes are named for one that measures nothing.
        DataError: A clean scene lacks an image or the scan.
    """
    check_validator(what, clean)
    if is_measured(what):
        arguments = {"name": what} if isinstance(what, str) else what
        clean = _kept_back(scenes) if clean is None else clean
        what, scenes = {**arguments, "thresholds": _measured(clean)}, _without(scenes, clean)
    if what is None:
        return None, scenes
    validator = cast("Validator", make(Kind.VALIDATOR, what))
    _check_sensors(validator, scenes)
    return validator, scenes


def check_validator(what: Any, clean: Any = None) -> None:
    """Refuse what cannot be known or does not fit together; nothing is loaded or measured.

    Args:
        what: The validator, as of `validator_and_played`.
        clean: The clean scenes, or what names them; see `check_frame_scenes`.

    Raises:
        ConfigurationError: Nothing has that name, or clean scenes are named for a validator that
            measures nothing.
        DataError: A folder of clean scenes is missing.
    """
    if is_measured(what):
        _check_measured({} if isinstance(what, str) else what)
    elif what is not None:
        check(Kind.VALIDATOR, what)
    if clean is None:
        return
    if not is_measured(what):
        raise ConfigurationError(
            "`clean` names the scenes that thresholds are measured on, which only the validator "
            f"'thresholds' without a table asks for, not {what!r}: leave it out"
        )
    check_frame_scenes(clean)


def _check_measured(arguments: Mapping[str, Any]) -> None:
    """That thresholds can be chosen by these arguments, once there is a table."""
    if set(arguments) <= {"name"}:
        return
    from avsec_gym.validation.thresholds import Criterion

    check(Kind.VALIDATOR, {**arguments, "thresholds": "a table that is not measured yet"})
    number("rate", arguments.get("rate", 0.0), 0.0, 1.0)
    one_of("criterion", arguments.get("criterion", "any"), get_args(Criterion))


def is_measured(what: Any) -> bool:
    """Whether its thresholds are measured on clean scenes of the game."""
    if isinstance(what, Mapping):
        return what.get("name") == "thresholds" and "thresholds" not in what
    return isinstance(what, str) and what == "thresholds"


def judges_by_others(what: Any) -> bool:
    """Whether a validator, named or live, judges the LiDAR by what connected vehicles scan."""
    named = what.get("name") if isinstance(what, Mapping) else getattr(what, "name", what)
    return isinstance(named, str) and named == "connected"


def _check_sensors(validator: Validator, scenes: FrameScenes) -> None:
    """Check on the first scene that the sensors which the validator judges are there."""
    frame = scenes.frame(scenes.scenes.labelled[0])
    if judges_by_others(validator):
        try:
            _ = frame.points, frame.connected
        except DataError as error:
            raise ConfigurationError(
                "the validator 'connected' cannot judge the scenes of"
                f" {scenes.scenes.name}: {error}"
            ) from error
        return
    try:
        for sensor in validator.system.sensors:
            _ = frame.points if sensor == LIDAR else frame.image(int(sensor))
    except DataError as error:
        judged = " ".join(map(str, validator.system.sensors))
        raise ConfigurationError(
            f"the validator judges the sensors {judged}, which the scenes of {scenes.scenes.name} "
            f"have not: {error} `avsec validate --sensors lidar 3 2` makes a table of the LiDAR "
            "and cameras 3 and 2."
        ) from error


@lru_cache(maxsize=8)  # The same scenes again, so that `_measured` knows them.
def _kept_back(scenes: FrameScenes) -> FrameScenes:
    half = len(scenes) // 2
    if half < FEWEST:
        raise ConfigurationError(
            f"{scenes.scenes.name} has {len(scenes)} scenes, too few to measure a validator's "
            f"thresholds on half of them, {FEWEST} or more, and to play the others: name scenes "
            "without attacks by `clean`, a table that `avsec validate` wrote by "
            '`validator={"name": "thresholds", "thresholds": "FILE"}`, or send it home by '
            "`validator=None`"
        )
    return replace(scenes, scenes=scenes.scenes.limited(half))


@lru_cache(maxsize=8)
def _measured(clean: FrameScenes) -> ThresholdTable:
    from avsec_gym.validation.detection import LIDAR_AND_TWO_CAMERAS
    from avsec_gym.validation.evidence.pair_depth import PairDepth
    from avsec_gym.validation.fitting import CleanFrames, fit_threshold_table
    from avsec_gym.validation.recordings import RecordedFrame

    frames = [RecordedFrame(scene.id, partial(clean.frame, scene)) for scene in _measured_on(clean)]
    data = {"scenes": clean.scenes.name}
    return fit_threshold_table(CleanFrames(frames, LIDAR_AND_TWO_CAMERAS, PairDepth(), data))


def _measured_on(clean: FrameScenes) -> tuple[Scene, ...]:
    return clean.scenes.labelled[:CLEAN]


def _without(scenes: FrameScenes, clean: FrameScenes) -> FrameScenes:
    """The scenes whose frames thresholds were not measured on."""

    def place(of: FrameScenes, scene: Scene) -> tuple[Path, str]:
        return of.data[scene.id].folder.resolve(), scene.id

    measured = {place(clean, scene) for scene in _measured_on(clean)}
    played = tuple(s for s in scenes.scenes.labelled if place(scenes, s) not in measured)
    if not played:
        raise ConfigurationError(
            f"all scenes of {scenes.scenes.name} are among those that thresholds are measured on, "
            "and none is left to be played: name others by `clean`"
        )
    return replace(scenes, scenes=replace(scenes.scenes, scenes=played))
