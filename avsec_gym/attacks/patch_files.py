"""`Patch`: what an attacker prints, and its files: safetensors, a picture, and a card."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from safetensors.torch import save
from torch import Tensor

from avsec_gym.argument_checks import shown
from avsec_gym.attacks.patch_ghosts import ghost_width
from avsec_gym.attacks.patch_names import CONTROLS, PATCHES, check_patch_name, patch_names
from avsec_gym.attacks.patch_pasting import disc
from avsec_gym.attacks.patch_placement import RADIUS, PatchRange
from avsec_gym.errors import ConfigurationError, DataError
from avsec_gym.kitti.sensor_files import write_image
from avsec_gym.perception.weights.tensor_files import read_tensors
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.json_fields import read_fields
from avsec_gym.storage.regular_files import is_there
from avsec_gym.storage.text_files import write_text

_ENLARGED = 4
_GREY = 127.5
_AGAIN = "Train it again with `avsec attack patch`."


@dataclass(frozen=True)
class PatchCard:
    """What is known of a trained patch; JSON beside the file.

    Args:
        detectors: The detectors that it was trained against: the SHA-256 of each one's weights by
            name.
        data: The frames.
        training: Configuration of the training, the seed included.
        losses: Losses to b*, by detector: means over new places in frames that it was trained on,
            of plain ``grey`` and of the ``patch``; none of a training that goes on.
        epochs: The number of passes over the frames.
        steps: Number of training steps.
        minutes: Duration of the training, minutes.
        versions: Versions of the software that made it.
        sha256: Hash of the file.

    Raises:
        ConfigurationError: The training's range or width of ghosts cannot be.
        TypeError: The training's range is none.
    """

    detectors: dict[str, str | None] = field(default_factory=dict)
    data: dict[str, Any] = field(default_factory=dict)
    training: dict[str, Any] = field(default_factory=dict)
    losses: dict[str, dict[str, float]] = field(default_factory=dict)
    epochs: int | None = None
    steps: int | None = None
    minutes: float | None = None
    versions: dict[str, str] = field(default_factory=dict)
    sha256: str = ""

    def __post_init__(self) -> None:
        _ = self.ghost_width, self.range  # A card that states impossible ones is refused.

    @property
    def ghost_width(self) -> float | None:
        """Width of the ghosts b* that it was trained towards, see `PatchTraining`."""
        width = self.training.get("ghost_width")
        return None if width is None else ghost_width(width)

    @property
    def range(self) -> PatchRange:
        """Where it stood in its training; the usual range where the card does not state it."""
        return PatchRange(**self.training.get("range", {}))


@dataclass(frozen=True, eq=False)
class Patch:
    """A round patch.

    Args:
        pixels: Grey levels 0..255 on the square around the disc, float32, shape (3, S, S).
        radius: Radius of the disc as cameras see it, pixels.
        card: Record of its training, if it was trained.

    Raises:
        ConfigurationError: Another shape, values beyond 0..255, or no positive radius.
    """

    pixels: Tensor
    radius: float = RADIUS
    card: PatchCard | None = None

    def __post_init__(self) -> None:
        shape = tuple(self.pixels.shape)
        if len(shape) != 3 or shape[0] != 3 or shape[1] != shape[2] or not shape[1]:
            raise ConfigurationError(f"a patch has shape (3, S, S), got {shape}")
        if not ((self.pixels >= 0) & (self.pixels <= 255)).all():
            raise ConfigurationError("a patch has grey levels in 0..255")
        if not 0 < self.radius < np.inf:
            raise ConfigurationError(f"a patch has a positive radius, got {self.radius}")

    @classmethod
    def grey(cls, radius: float = RADIUS) -> Patch:
        """The control without a pattern; training begins with it."""
        side = texels(radius)
        return cls(torch.full((3, side, side), _GREY), radius)

    @classmethod
    def noise(cls, seed: int = 0, radius: float = RADIUS) -> Patch:
        """The control with a pattern that means nothing: whole grey levels, uniform."""
        side = texels(radius)
        levels = np.random.default_rng(seed).integers(0, 256, (3, side, side))
        return cls(torch.from_numpy(levels).float(), radius)


def texels(radius: float) -> int:
    """The texels of a patch's side, one for each pixel of the image."""
    return int(np.ceil(2 * radius))


def shipped_patch(name: str) -> Path:
    """Where the package keeps the patch against a detector, or ``joint``; it may have none."""
    return PATCHES / f"{name}.safetensors"


def save_patch(path: str | Path, patch: Patch) -> Patch:
    """Write a patch, its picture (``.png``) and its card (``.json``), over earlier ones.

    Args:
        path: A ``.safetensors`` file.
        patch: The patch, with a card or without.

    Returns:
        The patch as written, the hash in its card.

    Raises:
        DataError: The place cannot be written.
    """
    path = Path(path)
    radius = torch.tensor(patch.radius, dtype=torch.float64)
    content = save({"pixels": patch.pixels.detach().cpu().contiguous(), "radius": radius})
    card = replace(patch.card or PatchCard(), sha256=hashlib.sha256(content).hexdigest())
    write_bytes(path, content, overwrite=True)
    write_text(_card_path(path), json.dumps(asdict(card), indent=1) + "\n", overwrite=True)
    write_image(path.with_suffix(".png"), _picture(patch), overwrite=True)
    return replace(patch, card=card)


def load_patch(path: str | Path) -> Patch:
    """Read a patch, with its card if one is there.

    Raises:
        DataError: The file is missing, damaged, no patch, or not the one of its card.
    """
    path = Path(path)
    if not is_there(path):
        raise DataError("There is no patch here.", path=path, remedy=_AGAIN)
    parts, content = read_tensors(path, remedy=_AGAIN)
    pixels, radius = parts.get("pixels"), parts.get("radius")
    if pixels is None or not pixels.is_floating_point() or radius is None or radius.ndim:
        raise DataError("This is no patch: one has pixels and a radius.", path=path, remedy=_AGAIN)
    try:
        patch = Patch(pixels.float(), float(radius.real))
    except ConfigurationError as error:
        raise DataError(f"This is no patch ({error}).", path=path, remedy=_AGAIN) from error
    card = _read_card(_card_path(path))
    if card is not None and card.sha256 != hashlib.sha256(content).hexdigest():
        raise DataError("The file is not the one of its card.", path=path, remedy=_AGAIN)
    return replace(patch, card=card)


def patch_of(what: Patch | str | Path) -> Patch:
    """The patch that a name, a file or an object stands for.

    Args:
        what: A patch, its file, or a name: of a control, ``grey`` or ``noise``, or of a patch
            of the package, ``dsgn``, ``stereo_rcnn`` or ``joint`` (against both).

    Raises:
        ConfigurationError: It is a mistyped name, or something else.
        DataError: The file is missing, damaged, or no patch.

    Example:
        >>> sorted(patch_of("joint").card.detectors)
        ['dsgn', 'stereo_rcnn']
    """
    if isinstance(what, Patch):
        return what
    if not isinstance(what, str | Path):
        names = ", ".join(patch_names())
        raise ConfigurationError(
            f"patch takes a file, a Patch, or one of {names}; got {shown(what)}"
        )
    check_patch_name(what)
    if str(what) in CONTROLS:
        return Patch.grey() if str(what) == "grey" else Patch.noise()
    return load_patch(shipped_patch(str(what)) if str(what) in patch_names() else what)


def _read_card(path: Path) -> PatchCard | None:
    if not is_there(path):
        return None
    try:
        return read_fields(PatchCard, path, remedy=_AGAIN)
    except ConfigurationError as error:
        raise DataError(
            f"This is no card of a patch ({error}).", path=path, remedy=_AGAIN
        ) from error


def _card_path(path: Path) -> Path:
    return path.with_suffix(".json")


def _picture(patch: Patch) -> np.ndarray:
    """The disc on white, enlarged, shape (H, W, 3)."""
    side = patch.pixels.shape[-1]
    offset = torch.arange(side) + 0.5 - side / 2
    opacity = disc(torch.hypot(offset[:, None], offset[None]), side / 2)
    pixels = (opacity * patch.pixels.detach().cpu() + (1 - opacity) * 255).round().byte()
    return pixels.permute(1, 2, 0).numpy().repeat(_ENLARGED, axis=0).repeat(_ENLARGED, axis=1)
