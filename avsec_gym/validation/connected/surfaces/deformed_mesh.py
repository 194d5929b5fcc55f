"""The second choice of surface: a closed mesh, deformed towards the points as in Point2Mesh.

For users of the library (docs/connected.md), who give it to a validator by surfaces as its mesher.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import torch
from scipy.spatial import QhullError, cKDTree
from torch import Tensor

from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.validation.connected.surfaces.mesh import SurfaceMesh
from avsec_gym.validation.connected.surfaces.self_prior import SelfPrior
from avsec_gym.validation.connected.surfaces.triangle_topology import (
    Integers,
    around_points,
    edges_of,
    subdivided,
)

_FEWEST = 10
_NEIGHBOURS = 8
"""Points that a normal is estimated from."""


@dataclass(frozen=True)
class DeformedMesh:
    """A mesher in the manner of Point2Mesh (Hanocka et al., SIGGRAPH 2020).

    A sphere of triangles is shrunk onto the points' convex hull; a network with shared weights, the
    self-prior, moves its vertices such that points sampled on it are near the given ones and the
    other way round, with like normals. Then the mesh is divided finer, and a new network goes on.

    It differs from the original: the first mesh is a sphere on the hull and not a remeshed hull or
    a coarse reconstruction; MeshCNN's convolutions stand without its pooling; normals are estimated
    from the points and have no sign; there is no beam-gap loss, which pulls the surface into deep
    cavities, since only what is seen from above is compared; instead of thousands of iterations
    with a remeshing to a watertight manifold there are two levels with some hundred each.

    Args:
        iterations: Steps of the optimiser at each level.
        levels: Times that triangles are divided, for each level.
        samples: Points that are sampled on the mesh, and taken of the given ones.
        normal_weight: Weight of the normals beside the distances.
        edge_weight: Weight of the edges' unequal lengths, which keeps triangles well shaped.
        seed: The seed of the networks' first weights and of all samples.

    Raises:
        ConfigurationError: A number that cannot be.

    Example:
        >>> points = np.random.default_rng(0).uniform(-1, 1, (40, 3))
        >>> DeformedMesh(iterations=1, samples=40)(points).triangles.shape
        (1280, 3)
    """

    iterations: int = 100
    levels: tuple[int, ...] = (2, 3)
    samples: int = 1500
    normal_weight: float = 0.02
    edge_weight: float = 0.02
    seed: int = 0

    def __post_init__(self) -> None:
        is_rising = all(a < b for a, b in pairwise(self.levels))
        if not self.levels or not is_rising or not 0 <= self.levels[0] <= self.levels[-1] <= 5:
            raise ConfigurationError(f"levels rise from 0 or more to 5 or less, got {self.levels}")
        if self.iterations < 1 or self.samples < 10:
            raise ConfigurationError("a mesh takes 1 iteration and 10 samples or more")

    def __call__(self, points: Floats) -> SurfaceMesh:
        """The mesh of points in a region's frame; empty where they lie in a plane. See `Mesher`."""
        if len(points) < _FEWEST:
            return SurfaceMesh.empty()
        # In a cube of half side 1, lengths mean the same for all objects.
        middle = (points.min(axis=0) + points.max(axis=0)) / 2
        scale = max(float(np.ptp(points, axis=0).max()) / 2, 1e-6)
        targets = _subset((points - middle) / scale, self.samples, self.seed)
        try:
            vertices, triangles = around_points(targets, self.levels[0])
        except QhullError:
            return SurfaceMesh.empty()
        normals = _normals(targets)
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(self.seed)
            for number, level in enumerate(self.levels):
                for _ in range(level - self.levels[number - 1] if number else 0):
                    vertices, triangles = subdivided(vertices, triangles)
                vertices = self._deformed(vertices, triangles, targets, normals)
        return SurfaceMesh(vertices * scale + middle, triangles)

    def _deformed(
        self, vertices: Floats, triangles: Integers, targets: Floats, normals: Floats
    ) -> Floats:
        """The vertices after one level's optimisation."""
        edges = edges_of(triangles)
        start = torch.from_numpy(vertices).float()
        corners, ends = torch.from_numpy(triangles), torch.from_numpy(edges.ends)
        aims, aimed_normals = torch.from_numpy(targets).float(), torch.from_numpy(normals).float()
        tree = cKDTree(targets)
        prior = SelfPrior(edges, len(vertices))
        optimiser = torch.optim.Adam(prior.parameters(), lr=2e-3)
        for _ in range(self.iterations):
            moved = start + prior()
            sampled, facing = _sampled(moved, corners, self.samples)
            # Which points are nearest is found without gradients, how far they are with them.
            found = sampled.detach().double().numpy()
            nearest = torch.from_numpy(tree.query(found)[1])
            back = torch.from_numpy(cKDTree(found).query(targets)[1])
            distance = (sampled - aims[nearest]).square().sum(1).mean()
            distance = distance + (aims - sampled[back]).square().sum(1).mean()
            # Estimated normals have no sign.
            unlike = 1 - (facing * aimed_normals[nearest]).sum(1).abs()
            lengths = (moved[ends[:, 0]] - moved[ends[:, 1]]).norm(dim=1)
            uneven = (lengths / (lengths.mean() + 1e-9)).var()
            loss = distance + self.normal_weight * unlike.mean() * distance.detach().sqrt()
            loss = loss + self.edge_weight * uneven * distance.detach()
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
        with torch.no_grad():
            return (start + prior()).double().numpy()


def _sampled(vertices: Tensor, triangles: Tensor, count: int) -> tuple[Tensor, Tensor]:
    """Points evenly on a mesh, and the normals of their triangles, shape (count, 3) each."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normal = torch.linalg.cross(b - a, c - a)
    twice_area = normal.norm(dim=1)
    chosen = torch.multinomial(twice_area.detach() + 1e-12, count, replacement=True)
    # The square root makes points of a triangle equally likely.
    root, second = torch.rand(count, 1).sqrt(), torch.rand(count, 1)
    places = (1 - root) * a[chosen] + root * (1 - second) * b[chosen] + root * second * c[chosen]
    return places, normal[chosen] / (twice_area[chosen, None] + 1e-9)


def _subset(points: Floats, count: int, seed: int) -> Floats:
    if len(points) <= count:
        return points
    return points[np.random.default_rng(seed).choice(len(points), count, replace=False)]


def _normals(points: Floats) -> Floats:
    """The direction in which a point's neighbours differ least, shape (N, 3)."""
    neighbours = points[cKDTree(points).query(points, min(_NEIGHBOURS, len(points)))[1]]
    centred = neighbours - neighbours.mean(axis=1, keepdims=True)
    _, directions = np.linalg.eigh(np.swapaxes(centred, 1, 2) @ centred)
    return directions[:, :, 0]
