"""A built scene: a site with road, land and scenery in place, and its light; actors are added."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache

import numpy as np
import shapely

from avsec_gym.geometry import Floats
from avsec_gym.world.actors import Actors
from avsec_gym.world.assets import part_of
from avsec_gym.world.mesh import Mesh
from avsec_gym.world.models.people import make_cyclist, make_person
from avsec_gym.world.models.vehicles import make_ego_vehicle, make_vehicle
from avsec_gym.world.rendering.light import Light
from avsec_gym.world.rendering.ray_scene import RayScene, Thing
from avsec_gym.world.rendering.renderer import Renderer
from avsec_gym.world.rendering.texturing import OverlayArrays
from avsec_gym.world.road.land import land_mesh
from avsec_gym.world.road.overlay import Overlay, paint_overlay
from avsec_gym.world.road.surface import road_meshes
from avsec_gym.world.scenery.composition import compose
from avsec_gym.world.scenery.plot import Placement
from avsec_gym.world.section import Surface
from avsec_gym.world.site import Site
from avsec_gym.world.textures.chosen import with_chosen_textures

SIGHT = 170.0
"""Metres from the camera beyond which single things are left out..."""
_UNSEEN_SIGHT = 100.0
"""... where no camera looks."""
_FIELD_OF_VIEW = 1.2
"""Tangent of half of it, with a margin: cameras look ahead."""
_COARSER = 45.0
"""Metres that things outside of it count as farther away."""


class BuiltScene:
    """All that stands still in a scene, and its light.

    Args:
        land: Meshes of road and terrain.
        overlay: Paint and wear of the road.
        placements: Houses, plants, furniture.
        light: The daylight.
        seed: Seed of the place, to whose part its textures belong.
    """

    def __init__(
        self,
        land: Sequence[Thing],
        overlay: OverlayArrays | None,
        placements: Sequence[Placement],
        light: Light,
        seed: int,
    ) -> None:
        self._land = [thing._replace(mesh=with_chosen_textures(thing.mesh, seed)) for thing in land]
        self._seed = seed
        self._overlay = overlay
        self._placements = list(placements)
        self._places = np.array([[p.x, p.y, p.reach] for p in placements]).reshape(-1, 3)
        self.light = light

    def scene(self, actors: Actors, looking: int, egos: Sequence[int] = ()) -> RayScene:
        """All that an actor's sensors may see; actor i has the object id i.

        Args:
            actors: All actors of the instant.
            looking: Index of the actor that looks; it does not see itself.
            egos: Indices of the actors that carry sensors.
        """
        return self._scene(actors, actors.pose[looking], looking, egos)

    def _scene(
        self, actors: Actors, viewpoint: Floats, looking: int | None, egos: Sequence[int]
    ) -> RayScene:
        """All that may be seen from a viewpoint x, y, heading; see `scene`."""
        # Leave out what is too far away to be seen, and more of what no camera faces.
        x, y, heading = viewpoint
        away = self._places[:, :2] - (x, y)
        distance, reach = np.hypot(*away.T), self._places[:, 2]
        ahead = away @ (np.cos(heading), np.sin(heading))
        aside = np.abs(away @ (-np.sin(heading), np.cos(heading)))
        unseen = aside > _FIELD_OF_VIEW * ahead + reach + 4.0
        things = list(self._land)
        for place in np.flatnonzero(distance - reach < np.where(unseen, _UNSEEN_SIGHT, SIGHT)):
            placement = self._placements[place]
            # What no camera looks at is for the LiDAR, for reflections and shadows.
            away_from = max(distance[place] - reach[place], 0.0) + _COARSER * unseen[place]
            mesh = with_chosen_textures(placement.mesh(float(away_from)), self._seed)
            things.append(Thing(mesh, placement.surface))
        for index in range(len(actors)):
            if index != looking:
                things.append(self._actor(actors, index, index in egos))
        return RayScene(things)

    def renderer(self, actors: Actors, looking: int, egos: Sequence[int] = ()) -> Renderer:
        """The renderer of `scene`."""
        return Renderer(self.scene(actors, looking, egos), self.light, self._overlay)

    def renderer_from(
        self, place: tuple[float, float, float], actors: Actors, egos: Sequence[int] = ()
    ) -> Renderer:
        """The renderer of what a fixed sensor may see: the scenery about it, and all actors.

        Args:
            place: x, y and heading of the sensor in the world.
            actors: All actors of the instant.
            egos: Indices of the actors that carry sensors.
        """
        scene = self._scene(actors, np.array(place), None, egos)
        return Renderer(scene, self.light, self._overlay)

    def clearance(self, x: float, y: float) -> float:
        """Metres from a place in the world to the nearest thing of the scenery; inf without any."""
        away = np.hypot(*(self._places[:, :2] - (x, y)).T) - self._places[:, 2]
        return float(away.min(initial=np.inf))

    def _actor(self, actors: Actors, index: int, carries_sensors: bool) -> Thing:
        x, y, heading = actors.pose[index].tolist()
        mesh = _ego_vehicle(self._seed) if carries_sensors else actor_mesh(actors, index)
        people = actors.category[index] in ("Pedestrian", "Person_sitting", "Cyclist")
        surface = Surface.PERSON if people else Surface.VEHICLE
        return Thing(mesh.placed(x, y, float(actors.z[index]), heading), surface, index)


def actor_mesh(actors: Actors, index: int) -> Mesh:
    """An actor in its own frame."""
    category = str(actors.category[index])
    height, width, length = actors.dimensions[index].tolist()
    dimensions = (height, width, length)
    appearance, phase = int(actors.appearance[index]), float(actors.phase[index])
    if category == "Cyclist":
        rider = make_cyclist(dimensions, appearance, phase)
        return with_chosen_textures(rider, appearance)
    if category in ("Pedestrian", "Person_sitting"):
        walking = bool(actors.moving[index])
        person = make_person(category, dimensions, appearance, phase, walking)
        return with_chosen_textures(person, appearance)
    return _vehicle(category, dimensions, appearance)


@lru_cache(maxsize=256)
def _vehicle(category: str, dimensions: tuple[float, float, float], appearance: int) -> Mesh:
    """Vehicles keep their looks: in a drive they are made once."""
    return with_chosen_textures(make_vehicle(category, dimensions, appearance), appearance)


@lru_cache(maxsize=4)
def _ego_vehicle(seed: int) -> Mesh:
    """With sensors, of the part of the place with this seed."""
    return with_chosen_textures(make_ego_vehicle(part_of(seed)), seed)


def build_scene(
    site: Site,
    light: Light,
    start: float,
    end: float,
    keep_clear: Iterable[shapely.Geometry] = (),
    painted: tuple[float, float] | None = None,
) -> BuiltScene:
    """Build up a site: road, land, paint, scenery.

    Args:
        site: The place; its seed draws everything.
        light: The daylight.
        start: Road coordinate along the main course at which the scene begins, metres.
        end: Road coordinate at which it ends, metres.
        keep_clear: Areas where no scenery may stand, in the world's ground plane.
        painted: Stretch of the road with markings and wear; all of it if None.
    """
    # One generator in a fixed order: land, then paint; scenery has one of its own.
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence((site.seed, 0))))
    land = [Thing(mesh, surface) for mesh, surface in road_meshes(site, start, end)]
    land.append(Thing(land_mesh(site, start, end, rng), Surface.TERRAIN))
    overlay = paint_overlay(site, *(painted or (start, end)), rng)
    placements = compose(site, start, end, keep_clear)
    return BuiltScene(land, _overlay_arrays(overlay, start), placements, light, site.seed)


def _overlay_arrays(overlay: Overlay, start: float) -> OverlayArrays:
    levels = overlay.levels()
    sizes = [level.shape[0] * level.shape[1] for level in levels]
    return OverlayArrays(
        texels=np.concatenate([level.reshape(-1, 4) for level in levels]),
        first=np.cumsum([0, *sizes[:-1]]),
        shape=np.array([level.shape[:2] for level in levels], np.int32),
        scale=np.full(2, 1.0 / overlay.metres_per_pixel, np.float32),
        begin=np.array([overlay.start - start], np.float32),
    )
