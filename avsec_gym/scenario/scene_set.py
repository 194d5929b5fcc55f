"""Scenes in order, with what reading them left to remark."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.scenario.given_scene import AS_GIVEN, GivenScene
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.scene import Scene


@dataclass(frozen=True, eq=False)
class SceneSet:
    """Scenes in order of their ids, and remarks from reading them."""

    name: str
    scenes: tuple[Scene | GivenScene, ...]
    remarks: tuple[str, ...] = ()
    skipped: int = 0
    """Files that were left out because they are broken; each has its remark."""
    intentions: Mapping[str, frozenset[Intention]] | None = None
    """The driving intentions that count in each scene, by its id; None: all."""

    def plays(self, id: str, intention: Intention) -> bool:
        """Whether an intention counts in a scene."""
        return self.intentions is None or intention in self.intentions[id]

    def driven(self, way: str) -> tuple[Scene | GivenScene, ...]:
        """The scenes that are driven with an intention, or with the goals that they give.

        Args:
            way: An intention, or `AS_GIVEN`.
        """
        if self.intentions is None or way == AS_GIVEN:
            return self.scenes
        return tuple(scene for scene in self.scenes if self.plays(scene.id, Intention(way)))

    def __len__(self) -> int:
        return len(self.scenes)

    @property
    def labelled(self) -> tuple[Scene, ...]:
        """The scenes, which all have labelled objects.

        Raises:
            ConfigurationError: One is given as a finished planning problem.
        """
        scenes = tuple(scene for scene in self.scenes if isinstance(scene, Scene))
        if len(scenes) < len(self.scenes):
            raise ConfigurationError(
                f"{self.name} holds planning problems of CommonRoad files; this needs scenes with"
                " labelled objects, such as 'layouts' or a folder of KITTI labels"
            )
        return scenes

    def without(self, errors: Mapping[str, DataError]) -> SceneSet:
        """The set without scenes that something is broken for, which is reported."""
        return replace(
            self,
            scenes=tuple(scene for scene in self.scenes if scene.id not in errors),
            remarks=(*self.remarks, *(f"left out: {error}" for error in errors.values())),
            skipped=self.skipped + len(errors),
        )

    def limited(self, count: int | None) -> SceneSet:
        """The first scenes only."""
        return self if count is None else replace(self, scenes=self.scenes[:count])


def collected(
    name: str,
    scenes: Sequence[Scene | GivenScene],
    remarks: Sequence[str],
    errors: Sequence[DataError],
) -> SceneSet:
    """A set of what could be read; what could not is reported, unless it is everything."""
    if errors and not scenes:
        raise errors[0]
    left_out = [f"left out: {error}" for error in errors]
    return SceneSet(name, tuple(scenes), (*remarks, *left_out), len(errors))
