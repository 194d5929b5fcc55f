"""`SelfPrior`: a network that moves the vertices of one mesh, and is trained on nothing else."""

from __future__ import annotations

from itertools import pairwise

import torch
from torch import Tensor, nn

from avsec_gym.validation.connected.surfaces.triangle_topology import Edges

_INPUTS = 6
_SMALL = 1e-2


class SelfPrior(nn.Module):
    """A network from fixed noise on the edges to displacements of the vertices.

    The weights are shared by all edges: what recurs over the object is learned once and fills in
    where points are missing, as smooth and as jagged as the rest (Hanocka et al., "Point2Mesh: a
    self-prior for deformable meshes", SIGGRAPH 2020). Convolutions are those of MeshCNN, without
    its pooling.

    Args:
        edges: The edges of the mesh.
        vertices: Number of vertices.
        channels: Features of an edge in the hidden layers.
        layers: Number of convolutions before the last layer.
    """

    def __init__(self, edges: Edges, vertices: int, channels: int = 32, layers: int = 3) -> None:
        super().__init__()
        self.ends = torch.from_numpy(edges.ends)
        self.neighbours = torch.from_numpy(edges.neighbours)
        self.vertices = vertices
        # The input never changes: the weights alone are what is fitted.
        self.noise = torch.rand(len(edges.ends), _INPUTS) - 0.5
        sizes = [_INPUTS, *layers * [channels]]
        self.convolutions = nn.ModuleList(
            nn.Linear(5 * before, after) for before, after in pairwise(sizes)
        )
        self.displacement = nn.Linear(channels, 6)
        # It begins with the mesh as it is.
        nn.init.normal_(self.displacement.weight, 0.0, _SMALL)
        nn.init.zeros_(self.displacement.bias)

    def forward(self) -> Tensor:
        """Displacements of the vertices, shape (V, 3): each the mean over its edges."""
        features = self.noise
        for number, convolution in enumerate(self.convolutions):
            out = torch.relu(convolution(self._with_neighbours(features)))
            out = (out - out.mean(0)) / (out.std(0) + 1e-5)
            features = out if number == 0 else features + out
        said = self.displacement(features).reshape(-1, 3)
        vertex = self.ends.reshape(-1)
        moved = torch.zeros(self.vertices, 3).index_add(0, vertex, said)
        count = torch.zeros(self.vertices).index_add(0, vertex, torch.ones(len(vertex)))
        return moved / count[:, None]

    def _with_neighbours(self, features: Tensor) -> Tensor:
        """Each edge beside sums and differences of opposite ones, in whatever order they stand."""
        a, b, c, d = (features[self.neighbours[:, k]] for k in range(4))
        return torch.cat([features, (a - c).abs(), a + c, (b - d).abs(), b + d], dim=1)
