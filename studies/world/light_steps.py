"""One frame, taken apart: what each step of the renderer adds, until a camera writes it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.frame import Image
from avsec_gym.geometry import Floats
from avsec_gym.world.capture import (
    Float32s,
    Geometry,
    PinholeCamera,
    Renderer,
    pinhole,
    render,
    renderer_of,
)
from avsec_gym.world.layouts import SceneLayout
from avsec_gym.world.posed_scenes import PosedScene
from avsec_gym.world.rendering.ambient import ambient_light, carry, smooth_ambient
from avsec_gym.world.rendering.camera import camera_rays, pixel_grid
from avsec_gym.world.rendering.image_sensor import tone_curve
from avsec_gym.world.rendering.ray_scene import NOTHING, Hits
from avsec_gym.world.rendering.shading import towards_disc
from avsec_gym.world.rendering.surfaces import Surfaces, surfaces
from avsec_gym.world.site import Surface
from studies.world.panels import panel_sheet
from studies.world.seen_from_above import layout_picture

_SUN_RAY = 0.0015
"""Angle of a ray to the sun, as the renderer has it, radians."""
_GRID_STEP = 5
"""Pixels between the points at which the sky is looked for, as the renderer has it."""
_MAGNIFIED = 8
_SCREEN = 1.0 / 2.2


def light_steps(layout: SceneLayout, posed: PosedScene, width: int) -> Image:
    """Eight panels in two columns, from the layout to the camera's 8 bits.

    Args:
        layout: The layout.
        posed: The scene that belongs to it.
        width: Width of the picture, pixels.
    """
    renderer = renderer_of(posed)
    camera = pinhole(posed.rig, posed.rig.stereo_pair[0], posed.vehicle_to_world[0])
    taken = render(posed, cameras=posed.rig.stereo_pair[:1], lidar=None, renderer=renderer)
    image = taken.images[posed.rig.stereo_pair[0]]
    exposed = _written(tone_curve(np.clip(renderer.view(camera).light, 0.0, 1.0)))
    panels = {
        "1 layout: labelled boxes and lanes": layout_picture(layout, camera.size),
        **_pictures(met_by_rays(renderer, posed, camera), camera.size),
        "6 all light: mirrors, glass and air too": exposed,
        "7 the camera's image: blur, glare, noise, 8 bits": image,
        "8 before the sensor, and after": _magnified(exposed, image, taken.geometry),
    }
    return panel_sheet(panels, 2, width)


class MetByRays(NamedTuple):
    """What the rays through the middles of n pixels meet; colours and normals of the sky are 0."""

    hits: Hits
    found: Surfaces
    """`sunlight` is that of surfaces nothing shades."""
    sunny: NDArray[np.bool_]
    """Whether the sun reaches each surface, shape (n,)."""
    around: Float32s
    """Light of the sky and of the surroundings, shape (n, 3)."""


def met_by_rays(renderer: Renderer, posed: PosedScene, camera: PinholeCamera) -> MetByRays:
    """The renderer's steps one by one, each by the function that the renderer calls.

    Args:
        renderer: Renderer of the scene.
        posed: The scene.
        camera: The view.
    """
    light, angle = posed.built.light, 1.0 / camera.focal_length
    origins, directions = camera_rays(camera, pixel_grid(*camera.size))
    hits = renderer.hits(origins, directions, angle)
    found = surfaces(renderer.arrays, hits, origins, directions, light.sun, angle)
    for values in (found.albedo, found.normal):
        values[hits.face < 0] = 0.0
    # A ray to the sun from each point that faces it; it passes one layer of leaves.
    facing = np.flatnonzero((hits.face >= 0) & (found.sunlight > 0.0))
    starts = np.ascontiguousarray(found.point[facing])
    sunny = np.zeros(len(hits.face), bool)
    towards = towards_disc(light.sun, starts)
    sunny[facing] = renderer.hits(starts, towards, _SUN_RAY, layers=1).face < 0
    return MetByRays(
        hits, found, sunny, _sky_and_surroundings(renderer, posed, camera, found, hits)
    )


def _pictures(met: MetByRays, size: tuple[int, int]) -> dict[str, Image]:
    """Of each step; the sky is black."""

    def shown(values: Float32s | Floats) -> Image:
        seen = (met.hits.face >= 0)[:, None]
        known = np.where(seen, np.broadcast_to(values, (len(seen), 3)), 0.0)
        return _written(known.reshape(size[1], size[0], 3))

    sun = met.found.sunlight * met.sunny
    return {
        "2 triangles, by their direction": shown(_triangles(met.hits, met.found.normal)),
        "3 materials, with the paint on the road": shown(_as_seen(met.found.albedo)),
        "4 light of the sun": shown(_as_seen(sun[:, None])),
        "5 light of sky and surroundings": shown(met.around / np.percentile(met.around, 98)),
    }


def _sky_and_surroundings(
    renderer: Renderer, posed: PosedScene, camera: PinholeCamera, found: Surfaces, hits: Hits
) -> Float32s:
    """Light that does not come straight from the sun, as the renderer finds it, shape (n, 3)."""
    light, (width, height) = posed.built.light, camera.size
    origins, directions = camera_rays(camera, pixel_grid(width, height, _GRID_STEP))
    angle = _GRID_STEP / camera.focal_length
    grid = renderer.hits(origins, directions, 1.0 / camera.focal_length)
    there = surfaces(renderer.arrays, grid, origins, directions, light.sun, angle)
    sun = (light.sun_colour, float(light.sun[2]))
    rough = ambient_light(renderer.scene, there, grid.face >= 0, light.panorama, *sun)
    columns, rows = -(-width // _GRID_STEP), -(-height // _GRID_STEP)
    smooth = np.empty_like(rough)
    smooth_ambient(rough, there.normal, grid.distance, columns, rows, smooth)
    out = np.zeros((len(hits.face), 3), np.float32)
    lattice = (_GRID_STEP, columns, rows, smooth, there.normal, grid.distance)
    carry(pixel_grid(width, height), found, hits.distance, *lattice, out)
    return out


def _triangles(hits: Hits, normal: Float32s) -> Floats:
    """Directions as colours, each triangle a little lighter or darker than its neighbours."""
    shade = 0.75 + 0.25 * (hits.face.astype(np.int64) * 2654435761 % 97) / 96.0
    return np.asarray((0.5 + 0.5 * normal) * shade[:, None])


def _magnified(exposed: Image, image: Image, seen: Geometry) -> Image:
    """A piece of the largest vehicle seen, before the sensor on the left and after it."""
    height, width = image.shape[:2]
    tall, wide = height // _MAGNIFIED, width // _MAGNIFIED // 2
    vehicles = np.where(seen.surface == Surface.VEHICLE, seen.object_id, NOTHING)
    largest = np.bincount(vehicles[vehicles > NOTHING], minlength=1).argmax()
    places = np.nonzero(vehicles == largest)
    row, column = (int(np.median(each)) if len(each) else 0 for each in places)
    top = min(max(row - tall // 2, 0), height - tall)
    left = min(max(column - wide // 2, 0), width - wide)
    pieces = [picture[top : top + tall, left : left + wide] for picture in (exposed, image)]
    return np.repeat(np.repeat(np.concatenate(pieces, axis=1), _MAGNIFIED, 0), _MAGNIFIED, 1)


def _as_seen(light: Float32s | Floats) -> Floats:
    """Linear light as a screen shows it."""
    return np.asarray(np.power(np.clip(light, 0.0, 1.0), _SCREEN))


def _written(values: Float32s | Floats) -> Image:
    return np.round(255.0 * np.asarray(np.clip(values, 0.0, 1.0), float)).astype(np.uint8)
