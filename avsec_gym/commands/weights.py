"""`avsec weights import`: published checkpoints as safetensors."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from avsec_gym import console
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.storage.regular_files import is_file, is_there

if TYPE_CHECKING:
    from typing import Any

    from torch import nn

    from avsec_gym.perception.depth.psmnet import PsmNetConfiguration

_DEFAULT_PRESETS = {"dsgn": "default", "stereo_rcnn": "resnet101", "psmnet": "full"}


@dataclass(frozen=True)
class WeightsImport:
    """Take a published checkpoint: check it against the network, and store it as safetensors.

    Nothing in the file is executed: the package reads its numbers by itself, and refuses the rest.
    """

    file: Annotated[Path, tyro.conf.Positional]
    """The checkpoint, such as a .tar, .pth or .pt file."""
    network: Literal["dsgn", "stereo_rcnn", "psmnet"]
    """The network whose checkpoint it is."""
    preset: str | None = None
    """Preset of the network's configuration. Default: the original's: default, resnet101, full."""
    aligned_corners: bool = False
    """Whether psmnet was trained with a torch that kept the corners' centres where they are when a
    map is enlarged (before 0.4, as the authors' own weights were). The file does not state it, and
    the wrong choice costs a pixel: choose one, or give a --pair."""
    no_aligned_corners: bool = False
    """Do not align corners, of psmnet: it was trained with torch's later default."""
    pair: tuple[Path, Path, Path] | None = None
    """A pair for psmnet: a left image, a right one, and the left one's disparities (a 16-bit PNG as
    in KITTI's disp_occ_0), at best of the data that it was trained on: both choices are tried on
    it, and the better one taken (two minutes)."""
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

        from avsec_gym.perception.weights.model_card import ModelCard
        from avsec_gym.perception.weights.published import load_published
        from avsec_gym.perception.weights.store import save_weights

        out = self.out or self.file.with_suffix(".safetensors")
        if out.suffix != ".safetensors":
            out = out.with_name(out.name + ".safetensors")
        there = [path for path in (out, out.with_suffix(".json")) if is_there(path)]
        if there and not self.overwrite:
            raise DataError(
                "This file exists and is left as it is.",
                path=there[0],
                remedy="Name another one with --out, or add --overwrite.",
            )
        self._check_corners()
        network, configuration = _network(self.network, self.preset)
        load_published(self.file, network)
        if self.network == "psmnet":
            configuration = configuration.with_corners(self._corners(network, configuration))
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
            console.print_json("weights.import", asdict(card))
        else:
            console.say(f"{out}: {card.parameters:,} parameters, {card.storage}")
        return console.DONE

    def _check_corners(self) -> None:
        """Check the options on how maps are enlarged.

        Raises:
            ConfigurationError: The choice is made twice, or for another network.
            DataError: A file of the pair is not there.
        """
        given = [self.aligned_corners, self.no_aligned_corners, self.pair is not None]
        if sum(given) > 1:
            raise ConfigurationError(
                "--aligned-corners, --no-aligned-corners and --pair exclude each other"
            )
        if any(given) and self.network != "psmnet":
            raise ConfigurationError(
                "--aligned-corners, --no-aligned-corners and --pair are for psmnet; the originals"
                f" of {self.network} leave no choice"
            )
        # Before the checkpoint, which takes its time.
        for path in self.pair or ():
            if not is_file(path):
                raise DataError("There is no such file.", path=path, remedy="Check --pair.")

    def _corners(self, network: nn.Module, configuration: PsmNetConfiguration) -> bool:
        """How a PSMNet enlarges its maps: as asked, as known of this file, or as measured.

        Raises:
            ConfigurationError: Neither the option nor the file states it.
            DataError: The pair is broken, or does not decide it.
        """
        from avsec_gym.perception.depth import corner_choice

        if self.aligned_corners or self.no_aligned_corners:
            return self.aligned_corners
        if self.pair is not None:
            pair = corner_choice.MeasuredPair.read(*self.pair)
            errors = corner_choice.end_point_errors(network.state_dict(), configuration, pair)
            aligned = corner_choice.measured_corners(errors, pair)
            console.say(
                f"mean error {errors[True]:.2f} px with aligned corners, {errors[False]:.2f} px"
                f" without: {'aligned' if aligned else 'not aligned'}"
            )
            return aligned
        known = corner_choice.known_corners(self.file)
        if known is None:
            raise ConfigurationError(
                "a PSMNet checkpoint does not tell whether corners stay where they are when its"
                " maps are enlarged, and the wrong choice costs a pixel of disparity: say"
                " --aligned-corners (the authors' own weights, torch before 0.4) or"
                " --no-aligned-corners (torch's later default), or give --pair LEFT RIGHT DISPARITY"
                " to have it measured"
            )
        return known


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
