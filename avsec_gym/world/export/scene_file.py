"""The scene file beside a procedural frame's labels: the road's type, and who is labelled."""

from __future__ import annotations

from pathlib import Path
from typing import TypedDict, cast

from avsec_gym.errors import DataError
from avsec_gym.road_type import RoadType
from avsec_gym.storage.json_fields import check_fields
from avsec_gym.storage.json_files import read_json_object


class _Numbered(TypedDict, total=False):
    actor: int
    """Its number, the same over a drive; scenes that stand alone need none."""


class SceneObject(_Numbered):
    """A labelled object; the file has more of each."""

    moving: bool


class SceneFile(TypedDict):
    """What is true of a frame beside its labels; the file has more."""

    road_type: RoadType
    objects: list[SceneObject]
    """Objects in the order of the label lines, without those of DontCare."""


def read_scene_file(path: str | Path, *, remedy: str) -> SceneFile:
    """Read the scene file of a frame.

    Args:
        path: The file.
        remedy: Advice to the user about a damaged one.

    Raises:
        DataError: It cannot be read, or lacks the road's type, or something of an object.
    """
    facts = read_json_object(path, remedy=remedy)
    try:
        check_fields(SceneFile, facts)
    except ValueError as error:
        raise DataError(f"This is no scene file: {error}.", path=path, remedy=remedy) from error
    return cast(SceneFile, facts)


def actors_of(scene: SceneFile) -> list[int] | None:
    """The number of each labelled object; None where one has none."""
    numbers = [each.get("actor") for each in scene["objects"]]
    known = [number for number in numbers if number is not None]
    return known if len(known) == len(numbers) else None
