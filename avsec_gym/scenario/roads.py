"""Which road scenes are driven on: the thesis' straight lanes, or the one that they lie on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from avsec_gym.errors import ConfigurationError
from avsec_gym.scenario.contested_sets import contested_sets
from avsec_gym.scenario.own_road import own_road_of
from avsec_gym.scenario.scene_set import SceneSet
from avsec_gym.world.layouts import layout_by_id

THESIS, OWN = "thesis", "own"
ROADS = (THESIS, OWN)
"""The thesis' straight lanes, and the road that a procedural scene lies on."""


def on_own_roads(scenes: SceneSet, layouts: Mapping[str, str] | None = None) -> SceneSet:
    """Procedural scenes on the roads that they lie on.

    An intention counts where the road has a lane for it.  What is contested is found out anew, as
    it is another question on another road.

    Args:
        scenes: Scenes of layouts.
        layouts: The id of each scene's layout, by the scene's id; None: they are the same.

    Raises:
        ConfigurationError: A scene is no layout's, or none is contested any more.
    """
    placed = []
    for scene in scenes.labelled:
        id = scene.id if layouts is None else layouts.get(scene.id, scene.id)
        try:
            layout = layout_by_id(id)
        except ConfigurationError:
            raise no_road_of_its_own(f"{scene.id} of {scenes.name}") from None
        placed.append(replace(scene, own_road=own_road_of(layout)))
    found = replace(scenes, scenes=tuple(placed))
    if scenes.intentions is not None:
        return replace(contested_sets().contested(found), name=scenes.name)
    return replace(found, intentions={scene.id: frozenset(scene.intentions) for scene in placed})


def no_road_of_its_own(what: str) -> ConfigurationError:
    """The error about scenes that no road is known of.

    Args:
        what: The scenes, for the message.
    """
    return ConfigurationError(
        f'{what} has no road of its own, which road="{OWN}" asks for: only procedural scenes have'
        f" one, such as 'layouts', 'mixed' or a folder of `avsec world make`; leave road out for"
        " the thesis' straight lanes"
    )
