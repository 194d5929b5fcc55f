"""`avsec weights import`: published checkpoints as safetensors."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from avsec_gym.commands import console
from avsec_gym.errors import DataError

if TYPE_CHECKING:
    from typing import Any

    from torch import nn

_DEFAULT_PRESETS = {"dsgn": "default", "stereo_rcnn": "resnet101", "psmnet": "full"}


@dataclass(frozen=True)
class WeightsImport:
    """Take a published checkpoint: check it against the network, and store it as safetensors.

    Nothing in the file is executed: it is read with torch's weights_only.
    """

    file: Annotated[Path, tyro.conf.Positional]
    """The checkpoint, such as a .tar, .pth or .pt file."""
    network: Literal["dsgn", "stereo_rcnn", "psmnet"]
    """Whose it is."""
    preset: str | None = None
    """Of the network's configuration.  Default: the original's: default, resnet101, full."""
    out: Path | None = None
    """The .safetensors file to write; a model card (.json) is put beside it.  Default: beside
    the checkpoint."""
    half: bool = False
    """Store float16: half the size, three digits."""
    overwrite: bool = False
    """Replace files that are there."""
    json: bool = False
    """Print the model card."""

    def run(self) -> int:
        """Do it; the exit code."""
        from dataclasses import asdict

        from avsec_gym.perception.weights.published import load_published
        from avsec_gym.perception.weights.store import ModelCard, save_weights

        out = self.out or self.file.with_suffix(".safetensors")
        if out.suffix != ".safetensors":
            out = out.with_name(out.name + ".safetensors")
        there = [path for path in (out, out.with_suffix(".json")) if path.exists()]
        if there and not self.overwrite:
            raise DataError(
                "This file exists and is left as it is.",
                path=there[0],
                remedy="Name another one with --out, or add --overwrite.",
            )
        network, configuration = _network(self.network, self.preset)
        load_published(self.file, network)
        card = save_weights(
            out,
            network,
            ModelCard(
                self.network,
                configuration=asdict(configuration),
                source=f"published checkpoint {self.file.name}",
                storage="float16" if self.half else "float32",
            ),
        )
        if self.json:
            console.print_json(asdict(card))
        else:
            console.say(f"{out}: {card.parameters:,} parameters, {card.storage}")
        return console.DONE


def _network(name: str, preset: str | None) -> tuple[nn.Module, Any]:
    """The network of a preset and its configuration."""
    preset = preset or _DEFAULT_PRESETS[name]
    if name == "psmnet":
        from avsec_gym.perception.depth.psmnet import PsmNet, PsmNetConfiguration

        return PsmNet(psmnet := PsmNetConfiguration.preset(preset)), psmnet
    if name == "dsgn":
        from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
        from avsec_gym.perception.detectors.dsgn.network import DsgnNetwork

        return DsgnNetwork(dsgn := DsgnConfiguration.preset(preset)), dsgn
    from avsec_gym.perception.detectors.stereo_rcnn.configuration import StereoRcnnConfiguration
    from avsec_gym.perception.detectors.stereo_rcnn.network import StereoRcnnNetwork

    return StereoRcnnNetwork(rcnn := StereoRcnnConfiguration.preset(preset)), rcnn
