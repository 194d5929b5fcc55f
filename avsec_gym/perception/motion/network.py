"""The moving-object classifier's network: the body of VGG-16, or of a small one, and two layers.

Keys of the body, ``features.0.weight`` and so on, are those of common VGG-16 checkpoints.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from avsec_gym.argument_checks import shown
from avsec_gym.errors import ConfigurationError

_KERNEL = 3


@dataclass(frozen=True)
class MotionConfiguration:
    """What the network is made of.

    Raises:
        ConfigurationError: Numbers that cannot be, or another preset.
    """

    stages: tuple[tuple[int, ...], ...]
    """Channels of the convolutions of each stage; pooling by two follows every stage."""
    crop: tuple[int, int]
    """Height and width of an object's crop, pixels."""
    neighbour: bool
    """Whether an earlier crop is looked at beside the current one."""
    hidden: int
    """Neurons between the two fully connected layers."""
    dropout: float = 0.5
    """Dropout before each of them."""
    normalised: bool = False
    """Batch normalisation after each convolution; VGG-16 has none."""

    def __post_init__(self) -> None:
        numbers = [self.hidden, *(channels for stage in self.stages for channels in stage)]
        if not self.stages or not all(self.stages) or min(numbers) < 1:
            raise ConfigurationError(
                f"every stage has a convolution, every layer a channel: {self}"
            )
        if min(self.crop) >> len(self.stages) < 1 or not 0 <= self.dropout < 1:
            raise ConfigurationError(
                f"a crop of {self.crop} pixels is too small for {len(self.stages)} stages, or the "
                f"dropout {self.dropout} is no share"
            )

    @classmethod
    def preset(cls, name: str) -> MotionConfiguration:
        """``vgg16``, the thesis' network, sees a single crop; ``small`` was trained here."""
        if name not in _PRESETS:
            raise ConfigurationError(
                f"there is no motion preset {shown(name)}; known: {', '.join(_PRESETS)}"
            )
        return _PRESETS[name]


_PRESETS = {
    # The thesis leaves the size of the new layer open.
    "vgg16": MotionConfiguration(
        ((64, 64), (128, 128), (256, 256, 256), (512, 512, 512), (512, 512, 512)),
        crop=(224, 224),
        neighbour=False,
        hidden=256,
    ),
    "small": MotionConfiguration(
        ((16,), (32, 32), (48, 48), (64, 64)),
        crop=(64, 64),
        neighbour=True,
        hidden=64,
        normalised=True,
    ),
}


@dataclass(frozen=True, eq=False)
class CropBatch:
    """Crops of N objects, grey levels 0..255.

    Args:
        now: The crops of the frame itself, shape (N, 3, H, W).
        before: The same places in an earlier frame under two stories, as they would look from
            here now: if the object stood, and if it drove the way that fits best; shape
            (N, 2, 3, H, W).
        known: Whether there is a `before`, shape (N,), bool.
    """

    now: Tensor
    before: Tensor
    known: Tensor

    def to(self, device: torch.device | str) -> CropBatch:
        """The crops on another device."""
        return CropBatch(self.now.to(device), self.before.to(device), self.known.to(device))


class MotionNetwork(nn.Module):
    """Logits of moving: convolutions, flatten, FC + ReLU, FC; a sigmoid makes them probabilities.

    Args:
        configuration: The configuration of the layers.
    """

    def __init__(self, configuration: MotionConfiguration) -> None:
        super().__init__()
        self.configuration = configuration
        layers: list[nn.Module] = []
        # Beside the colours: what has changed, and whether that is known.
        channels = 3 + 6 + 1 if configuration.neighbour else 3
        for stage in configuration.stages:
            for out in stage:
                layers.append(nn.Conv2d(channels, out, _KERNEL, padding=_KERNEL // 2))
                if configuration.normalised:
                    layers.append(nn.BatchNorm2d(out))
                layers.append(nn.ReLU(inplace=True))
                channels = out
            layers.append(nn.MaxPool2d(2))
        self.features = nn.Sequential(*layers)
        height, width = (side >> len(configuration.stages) for side in configuration.crop)
        self.classifier = nn.Sequential(
            nn.Flatten(),
            nn.Dropout(configuration.dropout),
            nn.Linear(channels * height * width, configuration.hidden),
            nn.ReLU(inplace=True),
            nn.Dropout(configuration.dropout),
            nn.Linear(configuration.hidden, 1),
        )
        for module in self.modules():
            if isinstance(module, nn.Conv2d):
                nn.init.kaiming_normal_(module.weight, nonlinearity="relu")
                nn.init.zeros_(_bias(module))
        mean = torch.tensor([0.485, 0.456, 0.406]).view(3, 1, 1)
        deviation = torch.tensor([0.229, 0.224, 0.225]).view(3, 1, 1)
        self.register_buffer("_mean", 255.0 * mean, persistent=False)
        self.register_buffer("_deviation", 255.0 * deviation, persistent=False)

    def forward(self, crops: CropBatch) -> Tensor:
        """Logits, shape (N,)."""
        deviation: Tensor = self.get_buffer("_deviation")
        x = (crops.now - self.get_buffer("_mean")) / deviation
        if self.configuration.neighbour:
            known = crops.known.to(x)[:, None, None, None]
            change = (crops.before - crops.now[:, None]) / deviation
            change = known * change.flatten(1, 2)
            x = torch.cat([x, change, known.expand(-1, 1, *x.shape[2:])], dim=1)
        logits: Tensor = self.classifier(self.features(x))
        return logits[:, 0]


def _bias(module: nn.Conv2d) -> Tensor:
    assert module.bias is not None, "made with one"
    return module.bias
