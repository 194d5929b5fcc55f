"""What was trained: a run's detectors, and the patches against them, as its options name them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from avsec_gym.attacks.patch_files import shipped_patch
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.experiments.chapter5.settings import DSGN, WITHOUT_PYRAMID, Options
from avsec_gym.perception.detectors.detector import Detector
from avsec_gym.perception.detectors.dsgn.editions import preset_name
from avsec_gym.perception.weights.given import shipped_weights
from avsec_gym.perception.weights.store import read_card
from avsec_gym.registry import Kind, make

TRAINED_PATCHES = ("patch", "joint")
"""A detector's own patch, and the one that was trained for both detectors."""
SIZES = ("small", "medium")
"""Presets that an option may name for the package's weights of them."""


def trained_detector(name: str, options: Options) -> Detector:
    """A detector with the weights that the options name, or those of the package.

    Args:
        name: One of `DETECTORS`, or `WITHOUT_PYRAMID`; it is the detector's `name`, too.
        options: Options with the weights, see `avsec_gym.experiments.chapter5.scenes.OPTIONS`.

    Raises:
        ConfigurationError: No weights are named, and the package has none by nature.
        DataError: The weights are missing, or those of another network.
    """
    weights = weights_file(name, options)
    if name == WITHOUT_PYRAMID:
        return _without_pyramid(weights)
    what = {"name": name, "weights": weights}
    card = read_card(weights) if name == DSGN else None
    if card is not None:
        what["configuration"] = preset_name(card)
    detector: Detector = make(Kind.DETECTOR, what)
    return detector


def weights_file(name: str, options: Options) -> Path:
    """Where a detector's weights are; errors as of `trained_detector`."""
    if name != WITHOUT_PYRAMID:
        given = options[name] or "small"
        return shipped_weights(f"{name}_{given}") if given in SIZES else Path(given)
    if not options.get(name):
        raise ConfigurationError(
            f"DSGN without its pyramid needs weights of its own: --options {name}=FILE"
        )
    path = Path(options[name])
    card = read_card(path)
    # The weights fit with and without the pyramid: only the card distinguishes them.
    if card is not None and card.configuration.get("features", {}).get("pyramid", False):
        raise DataError(
            "These weights were trained with the spatial pyramid pooling.",
            path=path,
            remedy="Train DSGN anew, with the pyramid switched off.",
        )
    return path


def patch_file(kind: str, detector: str, options: Options) -> Path:
    """Where a trained patch is, or would be.

    Args:
        kind: One of `TRAINED_PATCHES`.
        detector: The detector that it was trained against.
        options: ``patches`` names their folder.
    """
    shipped = shipped_patch("joint" if kind == "joint" else detector)
    return Path(options["patches"]) / shipped.name if options["patches"] else shipped


def patches_there(detector: str, options: Options) -> tuple[str, ...]:
    """Kinds of `TRAINED_PATCHES` that there are files of."""
    kinds = TRAINED_PATCHES
    return tuple(kind for kind in kinds if patch_file(kind, detector, options).is_file())


def trained_inputs(detectors: Sequence[str], options: Options) -> dict[str, Path]:
    """Files of weights and patches, by what they are; errors as of `trained_detector`."""
    weights = {f"weights of {name}": weights_file(name, options) for name in detectors}
    folder = patch_file("joint", "", options).parent
    return weights | {f"patch {path.stem}": path for path in sorted(folder.glob("*.safetensors"))}


def _without_pyramid(weights: Path) -> Detector:
    from avsec_gym.perception.detectors.dsgn.configuration import DsgnConfiguration
    from avsec_gym.perception.detectors.dsgn.detector import DsgnDetector

    small = DsgnConfiguration.preset("small")
    # Boxes are chosen as by the same network with its pyramid.
    rule = DsgnDetector(small).rule
    without = replace(small, features=replace(small.features, pyramid=False))
    detector = DsgnDetector(without, weights, rule=rule)
    detector.name = WITHOUT_PYRAMID  # Results are filed under it.
    return detector
