"""How far a patch spreads through the feature maps of a detector (thesis, 5.5.2, figure 5.8).

The patch stands in the middle of an image of uniform noise; what its presence changes in the output
of each layer of the feature extraction shows how far its effect reaches there.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor, nn

from avsec_gym.attacks.patch_files import Patch
from avsec_gym.attacks.patch_pasting import paste
from avsec_gym.attacks.patch_placement import PatchPlace
from avsec_gym.errors import ConfigurationError
from avsec_gym.geometry import Floats
from avsec_gym.perception.detectors.detector import Detector
from avsec_gym.perception.detectors.dsgn.detector import DsgnDetector
from avsec_gym.perception.detectors.dsgn.network import DsgnNetwork
from avsec_gym.perception.detectors.stereo_rcnn.detector import StereoRcnnDetector
from avsec_gym.perception.detectors.stereo_rcnn.network import StereoRcnnNetwork
from avsec_gym.perception.stereo_batch import StereoBatch, batch_of_images
from avsec_gym.rig import kitti_rig

LAYERS = (
    *(f"conv{i}" for i in range(1, 7)),
    "upsample1",
    *(f"smooth{i}" for i in range(1, 4)),
    "maxpool1",
    *(f"branch{i}" for i in range(1, 5)),
    *("fusion1", "fusion2"),
)
"""The thesis' names for those of both detectors, from shallow to deep; see `features`."""
_SIZE = (375, 1242)
_DISPARITY = 20.0
"""Pixels; it matters to the right image alone, whose features are not looked at."""

StereoNetwork = DsgnNetwork | StereoRcnnNetwork
Features = dict[str, Tensor]


@dataclass(frozen=True)
class SpreadExtent:
    """How far a patch spreads in one layer's output.

    All pixels are the camera's; radii are those of discs with the area of the cells in question.

    Args:
        cell: Side of a square with the area of one cell of the map, pixels.
        share: Share of the central square where the difference exceeds a share of its maximum.
        share_absolute: Share of it where the difference exceeds the same share of what another
            image of noise would change on average, which makes layers comparable.
        radius: Radius of a disc with the area of `share`, pixels.
        radius_absolute: Radius of a disc with the area of `share_absolute`, pixels.
        reach: Radius of a disc with the area of the cells that convolutions and pooling can carry
            the patch to at all.  Normalisation over groups of channels carries a trace of it
            everywhere.
    """

    cell: float
    share: float
    share_absolute: float
    radius: float
    radius_absolute: float
    reach: float


@dataclass(frozen=True, eq=False)
class LayerSpread:
    """What a patch changes in one layer's output.

    Args:
        layer: The thesis' name.
        difference: Mean over channels (and images) of its absolute value, in the central square,
            at every pixel of the image, shape (crop, crop).
        extent: How far that reaches.
    """

    layer: str
    difference: Floats
    extent: SpreadExtent


@dataclass(frozen=True, eq=False)
class FeatureSpread:
    """A patch's way through a detector.

    Args:
        image: The left image with the patch in the central square, (crop, crop, 3), in [0, 1].
        patch_radius: Radius of the patch, pixels.
        layers: The layers from shallow to deep.
    """

    image: Floats
    patch_radius: float
    layers: tuple[LayerSpread, ...]


@torch.no_grad()
def feature_spread(
    detector: Detector,
    patch: Patch,
    seed: int = 0,
    *,
    scenes: StereoBatch | None = None,
    images: int = 4,
    crop: int = 240,
    threshold: float = 0.1,
) -> FeatureSpread:
    """Follow a patch through the feature extraction, which sees each view by itself.

    Args:
        detector: A DSGN (with its pyramid pooling or without) or a Stereo R-CNN.
        patch: What is pasted; `Patch.noise` is the control that no attacker made.
        seed: Seed of the noise.
        scenes: Other pairs than noise to paste the patch into, two or more.  A trained network may
            be dead to noise, which is like nothing it has seen.
        images: Number of images of noise that maps are averaged over; two or more.
        crop: Side of the central square, pixels; the thesis does not state how large its is.
        threshold: Share of the maximum, or of what another image would change.

    Raises:
        ConfigurationError: Another detector, a square that is not in the image, or one image.
    """
    if not isinstance(detector, DsgnDetector | StereoRcnnDetector):
        raise ConfigurationError(f"the layers of {detector.name!r} are not known here")
    clean = _noise(seed, images) if scenes is None else scenes
    if not 0 < crop <= min(clean.size) or len(clean) < 2:
        raise ConfigurationError(
            f"the square lies within the image of {clean.size} pixels, and there are two images or"
            f" more, got {crop} pixels and {len(clean)} images"
        )
    # The patch stands in the middle; what it changes in the maps is what it reaches.
    v, u = ((side - 1) / 2 for side in clean.size)
    place = PatchPlace(u, v, _DISPARITY, radius=patch.radius)
    attacked = paste(clean, patch.pixels, [place] * len(clean))
    before, after = (_prepared(detector, batch) for batch in (clean, attacked))
    touched = ((before[0] - after[0])[:1].abs().amax(1, keepdim=True) > 0).double()
    plain, changed = (features(detector.network, image) for image, _ in (before, after))
    # What it could reach at all: the pixels that differ go through the same layers as means.
    reached = features(_carrier(detector.network), touched.expand(-1, 3, -1, -1))
    # Of each layer the share of the central square that changes: by more than a share of the
    # largest change, and by more than a share of what another image would change.
    layers = []
    for name, output in plain.items():
        grid = _MapGrid(
            clean.size, before[1], tuple(before[0].shape[-2:]), tuple(output.shape[-2:]), crop
        )
        difference = grid.central((changed[name] - output).abs().mean((0, 1)))
        # At the image's edges padding decides, not what is seen: the middle is typical.
        another = grid.central((output - output.roll(1, 0)).abs().mean((0, 1))).mean()
        share, share_absolute = (
            float((difference > threshold * whole).mean()) for whole in (difference.max(), another)
        )
        layers.append(
            LayerSpread(
                name,
                difference,
                SpreadExtent(
                    cell=grid.cell,
                    share=share,
                    share_absolute=share_absolute,
                    radius=crop * math.sqrt(share / math.pi),
                    radius_absolute=crop * math.sqrt(share_absolute / math.pi),
                    reach=grid.radius(reached[name].amax((0, 1)) > 0),
                ),
            )
        )
    middle = _central(attacked.left[0].permute(1, 2, 0).double().numpy() / 255, crop)
    return FeatureSpread(middle, patch.radius, tuple(layers))


def features(network: StereoNetwork, images: Tensor) -> Features:
    """Outputs of the layers that the thesis names, (B, C, h, w) each, from shallow to deep.

    DSGN: ``conv1`` are the three first convolutions, ``conv2`` to ``conv5`` the residual stages,
    ``branch1`` to ``branch4`` the means over windows before they are enlarged (missing where the
    pyramid is switched off), ``fusion1`` and ``fusion2`` the two convolutions that join them.
    Stereo R-CNN: ``conv1`` is the first convolution with its pooling, ``conv2`` to ``conv5`` the
    residual stages, ``conv6`` their 1x1 convolution (P5), ``upsample1`` the enlarged P5 with the
    lateral C4, ``smooth1`` to ``smooth3`` P4 to P2, ``maxpool1`` P6.

    Args:
        network: The network of either detector.
        images: Images as it takes them, shape (B, 3, H, W).
    """
    if isinstance(network, DsgnNetwork):
        extract = network.feature_extraction
        layers: dict[str, nn.Module] = {
            "conv1": extract.firstconv,
            **{f"conv{i + 1}": extract.get_submodule(f"layer{i}") for i in range(1, 5)},
            **{name: part for name, part in extract.named_children() if "branch" in name},
            "fusion1": extract.lastconv[1],
            "fusion2": extract.lastconv[2],
        }
        with _recorded(layers) as outputs:
            extract.lastconv(extract(images))
        return {name: outputs[name] for name in layers if name in outputs}
    layers = {f"conv{i + 1}": network.get_submodule(f"RCNN_layer{i}") for i in range(5)}
    layers |= {"conv6": network.RCNN_toplayer, "upsample1": network.RCNN_smooth1}
    layers |= {f"smooth{i}": network.get_submodule(f"RCNN_smooth{i}") for i in range(1, 4)}
    with _recorded(layers, given=("upsample1",)) as outputs:
        pyramid = network.features(images)
    return {name: outputs[name] for name in layers} | {"maxpool1": pyramid.levels[-1]}


@dataclass(frozen=True)
class _MapGrid:
    """How the cells of a map lie on the camera's image.

    Args:
        size: Height and width of the camera's image.
        inside: Size of the image as the network takes it.
        padded: The same with what is added to it at the right and below.
        cells: Size of the map.
        crop: Side of the central square, camera pixels.
    """

    size: tuple[int, int]
    inside: tuple[int, int]
    padded: tuple[int, ...]
    cells: tuple[int, ...]
    crop: int

    @property
    def cell(self) -> float:
        """Side of a square with a cell's area, camera pixels."""
        area = (
            np.prod(self.padded) / np.prod(self.cells) * np.prod(self.size) / np.prod(self.inside)
        )
        return float(np.sqrt(area))

    def radius(self, mask: Tensor) -> float:
        """The radius of a disc with the area of a map's marked cells, camera pixels."""
        return float(self.cell * np.sqrt(float(mask.sum()) / np.pi))

    def central(self, values: Tensor) -> Floats:
        """A map's middle, each pixel of the image with the value of its cell, (crop, crop)."""
        places = []
        for pixels, inside, padded, count in zip(
            self.size, self.inside, self.padded, self.cells, strict=True
        ):
            centre = (np.arange(pixels) + 0.5) * inside / pixels * count / padded
            places.append(np.minimum(centre.astype(int), count - 1))
        return _central(values.double().numpy()[np.ix_(*places)], self.crop)


def _central(image: Floats, crop: int) -> Floats:
    top, left = ((side - crop) // 2 for side in image.shape[:2])
    return np.asarray(image[top : top + crop, left : left + crop])


def _noise(seed: int, images: int) -> StereoBatch:
    """Uniform noise in both views."""
    generator = torch.Generator().manual_seed(seed)
    left, right = (torch.rand(images, 3, *_SIZE, generator=generator) * 255 for _ in range(2))
    return batch_of_images(left, right, [kitti_rig().calibration] * images)


def _prepared(
    detector: DsgnDetector | StereoRcnnDetector, batch: StereoBatch
) -> tuple[Tensor, tuple[int, int]]:
    """The left images as the network takes them, and the part of them that is image."""
    if isinstance(detector, DsgnDetector):
        given = detector.prepare(batch)
        return given.left, given.image_size
    left, _ = detector.prepare(batch)
    return left, (left.shape[-2], left.shape[-1])


def _carrier(network: StereoNetwork) -> StereoNetwork:
    """The same layers as means over what they see: an output above 0 can see an input above 0."""
    carrier = copy.deepcopy(network).double()
    for module in list(carrier.modules()):
        for name, part in list(module.named_children()):
            if isinstance(part, nn.GroupNorm | nn.BatchNorm2d | nn.BatchNorm3d):
                setattr(module, name, nn.Identity())
            elif isinstance(part, nn.Conv2d):
                part.weight.fill_(1 / part.weight[0].numel())
                if part.bias is not None:
                    part.bias.zero_()
    return carrier


@contextmanager
def _recorded(
    layers: dict[str, nn.Module], given: Sequence[str] = ()
) -> Iterator[dict[str, Tensor]]:
    """Outputs of layers while something runs; of those named in `given`, what they are given."""
    outputs: dict[str, Tensor] = {}

    def keep(name: str) -> Callable[..., None]:
        def hook(module: nn.Module, inputs: tuple[Tensor, ...], output: Tensor) -> None:
            # A copy: ReLU may work in place behind it.
            outputs[name] = (inputs[0] if name in given else output).detach().clone()

        return hook

    handles = [layer.register_forward_hook(keep(name)) for name, layer in layers.items()]
    try:
        yield outputs
    finally:
        for handle in handles:
            handle.remove()
