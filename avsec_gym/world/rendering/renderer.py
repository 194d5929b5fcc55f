"""Renders a scene: light, depth and object ids through a camera's pixels, echoes of a laser."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from avsec_gym.world.mesh import Float32s, Int32s
from avsec_gym.world.rendering.ambient import ambient_light, carry, smooth_ambient
from avsec_gym.world.rendering.camera import PinholeCamera, camera_rays, pixel_grid
from avsec_gym.world.rendering.edges import edge_marks
from avsec_gym.world.rendering.foliage import between_leaves
from avsec_gym.world.rendering.image_sensor import metered_exposure
from avsec_gym.world.rendering.light import Light
from avsec_gym.world.rendering.ray_scene import NOTHING, Hits, RayScene
from avsec_gym.world.rendering.scene_arrays import SceneArrays, break_up_lattice
from avsec_gym.world.rendering.shading import (
    radiance,
    smooth_over_surfaces,
    towards_disc,
)
from avsec_gym.world.rendering.surfaces import Surfaces, surfaces
from avsec_gym.world.rendering.texturing import OverlayArrays, no_overlay
from avsec_gym.world.section import Surface
from avsec_gym.world.textures.library import texture_library

_GRID_STEP = 5
_EXTRA = ((-0.30, -0.25), (0.32, 0.22))
"""Further rays through pixels on edges, in pixels from the centre: rows and columns differ."""
_DULL = 0.03
"""Surfaces that mirror less are not followed: they mirror the mean of their surroundings."""
_LOOKS_THROUGH = 3
"""Layers of leaves that a ray passes between; what is behind more is dark anyway."""
_SUN_ANGLE = 0.0015
"""Sun angle of the rays to the sun: single leaves cast their shadows from up to 40 m."""
_METERED = 10_000
"""Pixels of an image by which its exposure is found."""
_LAND = 0.72
"""Beneath a wide sky the land keeps so much of the brightness aimed for: the sky burns out..."""
_BURN = 1.15
"""... by this factor at most."""
_BRIGHTEST = np.float32(1.25)
"""Rays count as no brighter when a pixel's are averaged: bright edges stay smooth."""
_DAZZLING = np.float32(12.0)
"""What is brighter than this by its middle ray, the sun in varnish, counts as this bright."""
_PANES = 3
"""Panes of glass that a ray passes: into a car and out of it."""
_INSIDE = 0.30
"""Share of the light outside that reaches a car's seats."""
_SECOND_HAND = 0.02
"""Angle between the rays that show what is mirrored, radians."""


class Geometry(NamedTuple):
    """What the middle of each pixel shows."""

    depth: Float32s
    """Along the optical axis, metres, infinite for the sky, shape (H, W)."""
    object_id: Int32s
    """-1 for scenery and sky, shape (H, W)."""
    surface: NDArray[np.uint8]
    """`Surface`, shape (H, W)."""


class View(NamedTuple):
    """A rendered image before the sensor."""

    light: Float32s
    """Linear light times the exposure, 1 is the brightest that a sensor shows, shape (H, W, 3)."""
    geometry: Geometry
    dazzle: Float32s
    """Light beyond that: the sky, the sun in varnish; it blooms, shape (H, W, 3)."""


class Renderer:
    """Renders views of one scene under one light.

    Args:
        scene: The scene.
        light: The light.
        overlay: Overlay of the road; none if None.
    """

    def __init__(self, scene: RayScene, light: Light, overlay: OverlayArrays | None = None) -> None:
        self.scene = scene
        self._light = light
        haze = np.float32(light.haze)
        self._sky = (light.sun, light.sun_colour, light.panorama, light.horizon, haze)
        self._around = 0.5 * light.panorama.mean(axis=(0, 1))
        self.arrays = SceneArrays(
            scene.vertices,
            scene.normals,
            scene.uv,
            scene.overlay_uv,
            scene.faces,
            scene.material,
            scene.object_id,
            scene.materials,
            texture_library().arrays,
            overlay or no_overlay(),
            break_up_lattice(light.seed),
        )

    def geometry(self, camera: PinholeCamera) -> Geometry:
        """Depth, object ids and surfaces alone."""
        _, directions, hits = self._middle(camera)
        return self._geometry(camera, directions, hits)

    def view(self, camera: PinholeCamera) -> View:
        """Render; edges get more rays than plain areas."""
        width, height = camera.size
        # One ray through the middle of each pixel: geometry, and the surface with its light.
        pixels = pixel_grid(width, height)
        origins, directions, hits = self._middle(camera)
        geometry = self._geometry(camera, directions, hits)
        grid = self._ambient_grid(camera)
        found = self._surfaces(camera, directions, origins, hits)
        reached = self._sunny(found, hits.distance, pixels, width)
        light = self._light_along(camera, pixels, directions, hits, found, reached, grid)
        mirrored = self._mirror(directions, hits, found, light, pixels, width)
        reflects = found.mirror > 0.0
        # Expose: the sensor's range holds the image as a whole.
        metered = max(1, len(light) // _METERED)
        exposure = self._exposure(light[::metered], hits.face[::metered] >= 0)
        light *= exposure
        dazzle = np.clip(light, _BRIGHTEST, _DAZZLING) - _BRIGHTEST
        light = np.minimum(light, _BRIGHTEST)
        # More rays through pixels on edges; each counts as much as the middle's.
        kinds = geometry.surface.reshape(-1)
        edges = np.flatnonzero(
            edge_marks(light, hits.face, hits.distance, found.normal, kinds, width)
        )
        middle, own = hits.face, light[edges]
        plain = (middle < 0) | ~self.scene.materials.leaves[self.scene.material[middle]]
        for offset in _EXTRA:
            moved = pixels[edges] + np.array(offset, np.float32)
            origins, directions = camera_rays(camera, moved)
            hits = self.hits(origins, directions, 1.0 / camera.focal_length)
            # Textures and shadows are filtered: the middle's face looks the same all over the
            # pixel, but for single leaves.
            same = hits.face == middle[edges]
            new = np.flatnonzero(~(same & plain[edges]))
            hits = hits.of(new)
            found = self._surfaces(camera, directions[new], origins[new], hits)
            elsewhere = self._reached(found, np.flatnonzero(~same[new] & (found.sunlight > 0)))
            sunny = np.where(same[new], reached[edges[new]], elsewhere)
            more = self._light_along(camera, moved[new], directions[new], hits, found, sunny, grid)
            # What is mirrored hardly differs within a pixel: no rays of its own.
            share = found.mirror * reflects[edges[new]]
            more += share[:, None] * (mirrored[edges[new]] - more)
            seen = own.copy()
            seen[new] = np.minimum(more * exposure, _BRIGHTEST)
            light[edges] += seen
        light[edges] /= np.float32(1 + len(_EXTRA))
        dazzle[edges] /= np.float32(1 + len(_EXTRA))
        shape = (height, width, 3)
        return View(light.reshape(shape), geometry, dazzle.reshape(shape))

    def hits(
        self,
        origins: Float32s,
        directions: Float32s,
        pixel_angle: float,
        layers: int = _LOOKS_THROUGH,
    ) -> Hits:
        """First hits of rays; rays go on between leaves.

        Args:
            origins: Origins of the rays, metres, shape (n, 3).
            directions: Unit vectors along the rays, shape (n, 3).
            pixel_angle: Angle between neighbouring rays, radians.
            layers: Largest number of layers of leaves that a ray passes between.
        """
        # `every` holds the rays that still go on; `part` and `gaps` are in its order.
        found = self.scene.hits(origins, directions)
        every = np.arange(len(origins))
        part = found
        gaps = np.empty(len(origins), bool)
        for _ in range(layers):
            between_leaves(self.arrays, *part, np.float32(pixel_angle), gaps)
            open_rays = np.flatnonzero(gaps)
            if len(open_rays) == 0:
                break
            every = every[open_rays]
            passed = found.distance[every] + np.float32(2e-3)
            onward = np.ascontiguousarray(directions[every])
            part = self.scene.hits(origins[every] + passed[:, None] * onward, onward)
            part.distance[:] += passed
            for whole, new in zip(found, part, strict=True):
                whole[every] = new
            gaps = np.empty(len(every), bool)
        return found

    def _middle(self, camera: PinholeCamera) -> tuple[Float32s, Float32s, Hits]:
        origins, directions = camera_rays(camera, pixel_grid(*camera.size))
        return origins, directions, self.hits(origins, directions, 1.0 / camera.focal_length)

    def _geometry(self, camera: PinholeCamera, directions: Float32s, hits: Hits) -> Geometry:
        width, height = camera.size
        forward = camera.to_world[:3, 2].astype(np.float32)
        seen = hits.face >= 0
        face = np.maximum(hits.face, 0)
        depth = np.where(seen, hits.distance * (directions @ forward), np.inf)
        return Geometry(
            depth.astype(np.float32).reshape(height, width),
            np.where(seen, self.scene.object_id[face], NOTHING).reshape(height, width),
            np.where(seen, self.scene.surface[face], Surface.SKY)
            .astype(np.uint8)
            .reshape(height, width),
        )

    def _exposure(self, light: Float32s, land: NDArray[np.bool_]) -> np.float32:
        """The exposure that suits the image as a whole, and does not leave the land in the dark."""
        brightness = self._light.brightness
        exposure = metered_exposure(light, brightness)
        if land.any():
            for_land = metered_exposure(light[land], _LAND * brightness)
            exposure = max(exposure, min(for_land, _BURN * exposure))
        return np.float32(exposure)

    def _ambient_grid(self, camera: PinholeCamera) -> tuple[Float32s, Float32s, Float32s]:
        origins, directions = camera_rays(camera, pixel_grid(*camera.size, _GRID_STEP))
        hits = self.hits(origins, directions, 1.0 / camera.focal_length)
        light = self._light
        angle = _GRID_STEP / camera.focal_length
        found = surfaces(self.arrays, hits, origins, directions, light.sun, angle)
        open_light = ambient_light(
            self.scene,
            found,
            hits.face >= 0,
            light.panorama,
            light.sun_colour,
            float(light.sun[2]),
        )
        columns, rows = (-(-size // _GRID_STEP) for size in camera.size)
        smooth = np.empty_like(open_light)
        smooth_ambient(open_light, found.normal, hits.distance, columns, rows, smooth)
        return smooth, found.normal, hits.distance

    def _surfaces(
        self, camera: PinholeCamera, directions: Float32s, origins: Float32s, hits: Hits
    ) -> Surfaces:
        angle = 1.0 / camera.focal_length
        return surfaces(self.arrays, hits, origins, directions, self._light.sun, angle)

    def _sunny(self, found: Surfaces, distance: Float32s, pixels: Float32s, width: int) -> Float32s:
        """The share of the sun that reaches each pixel's surface, shape (n,).

        Every other pixel, as on a chess board, sends a ray to the sun; the others get the mean
        of neighbours on their surface, if there are any.
        """
        facing = found.sunlight > 0
        traced = facing & _chess_board(pixels)
        reached = self._reached(found, np.flatnonzero(traced))[:, None]
        reached = smooth_over_surfaces(reached, traced, facing, distance, found.normal, width)[:, 0]
        alone = np.flatnonzero(reached < 0)
        reached[alone] = self._reached(found, alone)[alone]
        return reached

    def _reached(self, found: Surfaces, which: NDArray[np.intp]) -> Float32s:
        """Whether the sun reaches some of the surfaces, 0 for the others, shape (n,)."""
        reached = np.zeros(len(found.sunlight), np.float32)
        reached[which] = ~self._shaded(np.ascontiguousarray(found.point[which]))
        return reached

    def _light_along(
        self,
        camera: PinholeCamera,
        pixels: Float32s,
        directions: Float32s,
        hits: Hits,
        found: Surfaces,
        reached: Float32s,
        grid: tuple[Float32s, Float32s, Float32s],
    ) -> Float32s:
        found.sunlight[:] *= reached
        ambient = np.zeros((len(pixels), 3), np.float32)
        columns, rows = (-(-size // _GRID_STEP) for size in camera.size)
        carry(pixels, found, hits.distance, _GRID_STEP, columns, rows, *grid, ambient)
        out = np.empty((len(pixels), 3), np.float32)
        radiance(hits.face, hits.distance, directions, found, ambient, *self._sky, out)
        self._look_through(directions, hits, found, out)
        return out

    def _look_through(
        self, directions: Float32s, hits: Hits, found: Surfaces, out: Float32s
    ) -> None:
        """Add what is seen through panes to `out`."""
        rays = np.flatnonzero((hits.face >= 0) & (found.clear > 0))
        passed = found.clear[rays, None] * found.albedo[rays]
        owner = self.scene.object_id[hits.face[rays]]
        point = found.point[rays]
        for _ in range(_PANES):
            if len(rays) == 0:
                return
            onward = np.ascontiguousarray(directions[rays])
            behind, surface, seen = self._second_hand(point + 0.03 * onward, onward, owner)
            out[rays] += passed * seen
            again = np.flatnonzero((behind.face >= 0) & (surface.clear > 0))
            passed = passed[again] * (surface.clear[again, None] * surface.albedo[again])
            rays, owner, point = rays[again], owner[again], surface.point[again]

    def _second_hand(
        self, starts: Float32s, directions: Float32s, inside: Int32s | None = None
    ) -> tuple[Hits, Surfaces, Float32s]:
        """What rays meet that were mirrored or went through a pane, and its light.

        It is lit without further rays: half of it lies in the shade.

        Args:
            starts: Origins of the rays, metres, shape (m, 3).
            directions: Unit vectors along the rays, shape (m, 3).
            inside: Objects within whose windows the rays begin, shape (m,): what belongs to
                them lies in the shade of their roofs.
        """
        light = self._light
        hits = self.scene.hits(starts, directions)
        found = surfaces(self.arrays, hits, starts, directions, light.sun, _SECOND_HAND)
        found.sunlight[:] *= 0.6
        ambient = np.empty_like(starts)
        ambient[:] = self._around
        if inside is not None:
            shaded = (hits.face >= 0) & (self.scene.object_id[hits.face] == inside)
            found.sunlight[shaded] = 0.0
            ambient[shaded] *= _INSIDE
        seen = np.empty_like(starts)
        radiance(hits.face, hits.distance, directions, found, ambient, *self._sky, seen)
        return hits, found, seen

    def _shaded(self, points: Float32s) -> NDArray[np.bool_]:
        """Whether points of the sun's disc are hidden; it shines through one layer of leaves."""
        to_sun = towards_disc(self._light.sun, points)
        found = self.scene.hits(points, to_sun)
        gaps = np.empty(len(points), bool)
        between_leaves(self.arrays, *found, np.float32(_SUN_ANGLE), gaps)
        shaded = found.face >= 0
        through = np.flatnonzero(gaps)
        passed = (found.distance[through] + np.float32(2e-3))[:, None]
        beyond = np.ascontiguousarray(points[through] + passed * to_sun[through])
        shaded[through] = self.scene.blocked(beyond, to_sun[through])
        return shaded

    def _mirror(
        self,
        directions: Float32s,
        hits: Hits,
        found: Surfaces,
        out: Float32s,
        pixels: Float32s,
        width: int,
    ) -> Float32s:
        """Mix what is mirrored into `out`; returns the mirrored light alone, shape (n, 3).

        Every other pixel, as on a chess board, is followed; the others get their neighbours'
        mean.
        """
        mirrored = np.empty_like(out)
        mirrored[:] = self._around
        distance, mirrors = hits.distance, (found.mirror > _DULL) & (hits.face >= 0)
        followed = mirrors & _chess_board(pixels)
        rays = np.flatnonzero(followed)
        normal, incoming = found.normal[rays], directions[rays]
        facing = (incoming * normal).sum(axis=1, keepdims=True)
        outgoing = np.ascontiguousarray(incoming - 2 * facing * normal)
        starts = np.ascontiguousarray(found.point[rays])
        _, _, seen = self._second_hand(starts, outgoing)
        mirrored[rays] = seen
        mirrored = smooth_over_surfaces(mirrored, followed, mirrors, distance, found.normal, width)
        shiny = np.flatnonzero(found.mirror > 0.0)
        mirrored[shiny] = np.where(mirrored[shiny] < 0, self._around, mirrored[shiny])
        out[shiny] += found.mirror[shiny, None] * (mirrored[shiny] - out[shiny])
        return mirrored


def _chess_board(pixels: Float32s) -> NDArray[np.bool_]:
    """The white squares, shape (n,)."""
    return np.asarray((pixels[:, 0] + pixels[:, 1]).astype(np.int32) & 1 == 0)
