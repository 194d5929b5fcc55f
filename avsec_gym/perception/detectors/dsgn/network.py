"""DSGN's network (Chen et al., CVPR 2020): a stereo pair to boxes at bird's-eye-view anchors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional

from avsec_gym.perception.detectors.dsgn.box_field import BoxField
from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
from avsec_gym.perception.nn.convolution import (
    Dimensions,
    VolumeConvolution,
    convolution,
    convolutions,
    initialise,
)
from avsec_gym.perception.nn.correlation_volume import correlation_volume
from avsec_gym.perception.nn.cost_volume import enlarged, expectation, sampled_volume
from avsec_gym.perception.nn.hourglass import Hourglass
from avsec_gym.perception.nn.pyramid_pooling import STRIDE, FeatureExtraction


@dataclass(frozen=True, eq=False)
class DsgnOutput:
    """What the network predicts of B pairs; A anchor angles, K classes, Z x X bird's-eye cells.

    Args:
        depth: Expected depth of every pixel of the left image, metres, shape (B, H, W).
        depth_logits: Depth scores before the softmax over D depths (dimension 1), shape (B, D, h,
            w): of the pixels of the image in the full configurations, of those of the features in
            `small`.
        depth_bins: The depths in metres, far to near, shape (D,).
        class_logits: Class scores before the sigmoid, shape (B, A, K, Z, X).
        boxes: The boxes of every anchor.
        centerness: Centerness before the sigmoid, shape (B, A, Z, X).
        reversal: Direction before the sigmoid: whether the box heads the other way than its
            corners state, shape (B, A, K, Z, X); None without `half_turns`.
        fit: Fit before the sigmoid: the intersection over union of the box with the object, shape
            (B, A, K, Z, X); None without `fit`.

    Rows of the bird's-eye view run as ``configuration.grid.z`` does, from far to near, its columns
    as ``configuration.grid.x``, from left to right; ``.centres()`` of both gives metres.
    """

    depth: Tensor
    depth_logits: Tensor
    depth_bins: Tensor
    class_logits: Tensor
    boxes: BoxField
    centerness: Tensor
    reversal: Tensor | None = None
    fit: Tensor | None = None

    @property
    def corners(self) -> Tensor:
        """The eight corners of each box less its anchor's place.

        The place is x of the cell, ``centre_y`` of the class, z of the cell; corners are (x, y, z)
        in metres of the camera frame: (+l/2, +w/2), (+l/2, -w/2), (-l/2, -w/2), (-l/2, +w/2) of the
        bottom face, then of the top; shape (B, A, K, 8, 3, Z, X).
        """
        return self.boxes.everywhere()


class DsgnNetwork(nn.Module):
    """The detector without what stands before it (scaling) and behind it (decoding).

    The names of its parts are those of the original's ``state_dict``.
    """

    def __init__(self, configuration: DsgnConfiguration) -> None:
        super().__init__()
        self.configuration = c = configuration
        # Features of both images become a volume over image and disparity, with costs of depths.
        self.feature_extraction = FeatureExtraction(c.features)
        wide, pair = c.volume_channels, c.correlation_groups or 2 * c.features.matching[1]
        self.dres0: nn.Module
        if c.volume_begins_with_hourglass:
            self.dres0 = Hourglass(pair, groups=c.groups, dimensions=3)
        else:
            self.dres0 = self._layers(3, pair, wide, wide)
            self.dres1 = nn.Sequential(
                *self._layers(3, wide, wide),
                convolution(wide, wide, groups=c.groups, dimensions=3),
            )
            self.dres2 = Hourglass(wide, groups=c.groups, dimensions=3)
        self.classif1 = nn.Sequential(
            *self._layers(3, wide, wide, kernel=c.cost_kernel),
            VolumeConvolution(wide, 1, c.cost_kernel, padding=c.cost_kernel // 2, bias=False),
        )
        # Sampled at a grid in space, and laid flat to the view from above.
        semantic = 0 if c.features.semantic is None else c.features.semantic[1]
        sampled = wide + c.costs_in_grid + semantic
        self.rpn3d_conv = self._layers(3, sampled, c.grid_channels, kernel=c.grid_kernel)
        if c.grid_hourglass:
            self.hg_rpn3d_conv = Hourglass(c.grid_channels, groups=c.groups, dimensions=3)
        heights = c.grid.y.cells // c.pooled_heights
        view = c.view_channels
        self.rpn3d_conv2 = self._layers(2, heights * c.grid_channels, view)
        self.rpn3d_conv3 = Hourglass(view, groups=c.groups, dimensions=2)
        # Two towers, for classes and for boxes, and the heads at their ends.
        tower = [view] * (c.tower_length + 1)
        self.rpn3d_cls_convs = self._layers(2, *tower)
        self.rpn3d_bbox_convs = self._layers(2, *tower)
        self.rpn3d_cls_convs2 = self._layers(2, *tower)
        self.rpn3d_bbox_convs2 = self._layers(2, *tower)
        classes = len(c.anchors)
        self.bbox_cls = nn.Conv2d(view, c.angles * classes, 3, padding=1)
        self.bbox_centerness = nn.Conv2d(view, c.angles, 3, padding=1)
        self.bbox_reg = nn.Conv2d(view, classes * (6 + c.angles), 3, padding=1)
        beside = [*["bbox_reversal"] * c.half_turns, *["bbox_fit"] * c.fit]
        for name in beside:
            self.add_module(name, nn.Conv2d(view, c.angles * classes, 3, padding=1))
        self._register_places()
        # Heads begin with small weights.
        initialise(self)
        for layer, deviation in (
            (self.bbox_cls, 0.1),
            (self.bbox_centerness, 0.1),
            (self.bbox_reg, 0.02),
            *((self.get_submodule(name), 0.02) for name in beside),
        ):
            nn.init.normal_(layer.get_parameter("weight"), std=deviation)
        nn.init.constant_(
            self.bbox_cls.get_parameter("bias"), -math.log(99)
        )  # a prior probability of 1 %

    def _register_places(self) -> None:
        """Depths, and the grid's cells, on the device of the weights, but no part of them."""
        c = self.configuration
        for name, values in {
            "plane_depths": c.planes.values(),
            "bin_depths": c.bins.values(),
            "grid_x": c.grid.x.centres(),
            "grid_y": c.grid.y.centres(),
            "grid_z": c.grid.z.centres(),
            "grid_depth": c.sampled.position(c.grid.z.centres()),
        }.items():
            self.register_buffer(name, torch.from_numpy(values), persistent=False)

    def _layers(self, dimensions: Dimensions, *channels: int, kernel: int = 3) -> nn.Sequential:
        return convolutions(
            *channels, groups=self.configuration.groups, dimensions=dimensions, kernel=kernel
        )

    def forward(
        self, left: Tensor, right: Tensor, projection: Tensor, focal_times_baseline: Tensor
    ) -> DsgnOutput:
        """Boxes at every anchor and the depth of every pixel.

        Args:
            left: Normalised by ImageNet's mean and deviation, padded, shape (B, 3, H, W).
            right: The same shape.
            projection: P of the left camera for these pixels, shape (B, 3, 4).
            focal_times_baseline: Disparity times depth, pixels x metres, shape (B,).
        """
        extract = self.feature_extraction
        joined, joined_right = extract(torch.cat([left, right])).chunk(2)
        match, match_right = extract.lastconv(joined), extract.lastconv(joined_right)
        volume, costs = self._volume(match, match_right, self._disparities(focal_times_baseline))
        logits = self._depth_logits(costs, left)
        semantic = extract.rpnconv(joined) if self.configuration.features.semantic else None
        world = self._world(volume, costs, logits, semantic, projection, left)
        heads = self._heads(self._view(world))
        bins = self.get_buffer("bin_depths").to(left)
        depth = expectation(logits, bins)
        if not self.configuration.full_depth:
            depth = _at_pixels(depth)
        return DsgnOutput(depth, logits, bins, *heads)

    def _disparities(self, focal_times_baseline: Tensor) -> Tensor:
        """Of the planes in pixels of the features, shape (B, D)."""
        depths = self.get_buffer("plane_depths").to(focal_times_baseline)
        return focal_times_baseline[:, None] / depths / STRIDE

    def _volume(self, left: Tensor, right: Tensor, disparities: Tensor) -> tuple[Tensor, Tensor]:
        """Features (B, C, D, h, w) and costs (B, 1, D, h, w) of the planes."""
        c = self.configuration
        if c.correlation_groups:
            pairs = correlation_volume(left, right, disparities, c.correlation_groups)
        else:
            pairs = sampled_volume(left, right, disparities)
        if c.volume_begins_with_hourglass:
            volume, _, _ = self.dres0(pairs)
            volume = volume + pairs if c.volume_residual else volume
        else:
            volume = self.dres0(pairs)
            volume = volume + self.dres1(volume)
            volume = volume + self.dres2(volume)[0]
        return volume, self.classif1(volume)

    def _depth_logits(self, costs: Tensor, image: Tensor) -> Tensor:
        """Of the bins, shape (B, D, H, W), or (B, D, h, w) without full depth."""
        place = image.shape[-2:] if self.configuration.full_depth else costs.shape[-2:]
        size = (self.configuration.bins.count, *place)
        if costs.shape[2:] == size:
            return costs[:, 0]
        return enlarged(costs[:, 0], size, aligned_corners=True)

    def _world(
        self,
        volume: Tensor,
        costs: Tensor,
        logits: Tensor,
        semantic: Tensor | None,
        projection: Tensor,
        image: Tensor,
    ) -> Tensor:
        """What the voxels of the world grid hold, shape (B, C, Z, Y, X)."""
        places = self._places(projection, image.shape[-2:]).to(image)
        seen = (places.abs() <= 1).all(-1)[:, None]
        if self.configuration.costs_in_grid:
            volume = torch.cat([volume, self._fixed(costs)], 1)
        sampled = self._sampled(volume, places) * seen
        if semantic is None:
            return sampled
        in_image = (places[..., :2].abs() <= 1).all(-1)[:, None]
        meaning = self._sampled(semantic, places[..., :2].flatten(1, 2))
        meaning = meaning.reshape(*meaning.shape[:2], *places.shape[1:4]) * in_image
        probability = self._fixed(logits).softmax(1)[:, None]
        there = self._sampled(probability, places) * seen
        return torch.cat([sampled, meaning * there], 1)

    def _fixed(self, values: Tensor) -> Tensor:
        """Depth learns from depth alone, as in the original; an attacker gets the true gradient."""
        return values.detach() if self.training else values

    def _sampled(self, features: Tensor, places: Tensor) -> Tensor:
        return functional.grid_sample(
            features, places, align_corners=self.configuration.aligned_corners
        )

    def _places(self, projection: Tensor, size: Sequence[int]) -> Tensor:
        """Where the voxels lie in the volume: u, v and depth in [-1, 1], (B, Z, Y, X, 3)."""
        c = self.configuration
        z, y, x, depth = (
            self.get_buffer(name).to(projection)
            for name in ("grid_z", "grid_y", "grid_x", "grid_depth")
        )
        p = projection[:, :, :, None, None, None]
        homogeneous = p[:, :, 0] * x + p[:, :, 1] * y[:, None] + p[:, :, 2] * z[:, None, None]
        homogeneous = homogeneous + p[:, :, 3]
        u, v = (homogeneous[:, :2] / homogeneous[:, 2:]).unbind(1)
        # The pixel at which the volume ends: -1 and 1 are the places of its outermost features.
        beyond = STRIDE if c.exact_pixels else 1
        bottom, right = size[0] - beyond, size[1] - beyond
        depth = depth[:, None, None].expand_as(u)
        return torch.stack([2 * u / right - 1, 2 * v / bottom - 1, depth], -1)

    def _view(self, world: Tensor) -> Tensor:
        """The bird's-eye view, shape (B, C, Z, X)."""
        world = self.rpn3d_conv(world)
        if self.configuration.grid_hourglass:
            world = world + self.hg_rpn3d_conv(world)[0]
        if self.configuration.pooled_heights > 1:
            world = functional.avg_pool3d(world, (1, self.configuration.pooled_heights, 1))
        stacked = world.transpose(2, 3).flatten(1, 2)
        # The original forgets the residual here; its weights are trained without.
        return self.rpn3d_conv3(self.rpn3d_conv2(stacked))[0]

    def _heads(self, view: Tensor) -> tuple[Tensor, BoxField, Tensor, Tensor | None, Tensor | None]:
        """Class logits, boxes, centerness, reversal and fit; see `DsgnOutput`."""
        c = self.configuration
        cls = self.rpn3d_cls_convs2(self.rpn3d_cls_convs(view))
        box = self.rpn3d_bbox_convs2(self.rpn3d_bbox_convs(view))
        classes = len(c.anchors)

        def of_anchors(values: Tensor) -> Tensor:
            return values.reshape(len(values), c.angles, classes, *values.shape[2:])

        return (
            of_anchors(self.bbox_cls(cls)),
            BoxField(self.bbox_reg(box).unflatten(1, (classes, 6 + c.angles)), c),
            self.bbox_centerness(box),
            of_anchors(self.get_submodule("bbox_reversal")(box)) if c.half_turns else None,
            of_anchors(self.get_submodule("bbox_fit")(box)) if c.fit else None,
        )


def _at_pixels(depth: Tensor) -> Tensor:
    """(B, h, w) of the features to the image's pixels: that of feature i stands at 4 i."""
    height, width = depth.shape[-2:]
    between = functional.interpolate(
        depth[:, None],
        size=(STRIDE * (height - 1) + 1, STRIDE * (width - 1) + 1),
        mode="bilinear",
        align_corners=True,
    )
    return functional.pad(between, (0, STRIDE - 1, 0, STRIDE - 1), mode="replicate")[:, 0]
