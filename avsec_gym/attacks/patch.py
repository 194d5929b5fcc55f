"""The patch attack: a printed pattern in the view makes detectors see a car (thesis, 5.4.3)."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal

from avsec_gym.argument_checks import instance_or_none, label, number, one_of
from avsec_gym.attacks.argument_domains import RADII
from avsec_gym.attacks.attack import LEFT, Budget, Seed, Victim
from avsec_gym.attacks.patch_files import Patch, PatchCard, patch_of
from avsec_gym.attacks.patch_pasting import largest_area, paste_on_frame
from avsec_gym.attacks.patch_placement import (
    PatchPlace,
    PatchRange,
    random_place,
    specific_place,
)
from avsec_gym.frame import SensorFrame
from avsec_gym.perception.weights.weights_hash import weights_hash

_LOG = logging.getLogger(__name__)
_REPORTED: set[str] = set()


@dataclass(frozen=True)
class PatchAttack:
    """An `Attack` with one patch, pasted into both views at a disparity that can be.

    Args:
        patch: A patch, its file, or a name: of a control, ``grey`` or ``noise``, or of a patch
            of the package, ``dsgn``, ``stereo_rcnn`` or ``joint`` (against both).
        placement: ``random``: anywhere in the image; ``specific``: in the third of the image that
            the driving intention points to.
        radius: Radius in pixels of the camera's own image; None: that of the patch.
        range: Range of its distances and tilts; None: that of the patch's training.
        name: Name of the attack in results.

    Raises:
        ConfigurationError: There is no such placement, or no positive radius.
        DataError: The file is missing, damaged, or no patch.
    """

    patch: Patch | str | Path
    placement: Literal["random", "specific"] = "random"
    radius: float | None = None
    range: PatchRange | None = None
    name: str = "patch"

    def __post_init__(self) -> None:
        one_of("placement", self.placement, ("random", "specific"))
        if self.radius is not None:
            object.__setattr__(self, "radius", number("radius", self.radius, *RADII))
        instance_or_none("range", self.range, PatchRange)
        label("name", self.name)
        object.__setattr__(self, "patch", patch_of(self.patch))

    @property
    def budget(self) -> Budget:
        """Everything inside of one disc."""
        return Budget(change=255.0, area=largest_area(self._radius))

    @property
    def stands_in(self) -> PatchRange:
        """The range of its distances and tilts."""
        card = self._patch.card
        return self.range or (PatchRange() if card is None else card.range)

    @property
    def ghost_width(self) -> float | None:
        """Width of the ghosts b* that the patch was trained towards, see `ghost_box`."""
        card = self._patch.card
        return None if card is None else card.ghost_width

    def placed(self, frame: SensorFrame, victim: Victim, seed: Seed = 0) -> PatchPlace:
        """Where `attack` puts the patch for this seed; the detector has no part in it."""
        draw = random_place
        if self.placement == "specific":
            draw = partial(specific_place, victim.intention)
        return draw(
            frame.calibration,
            frame.image(LEFT).shape[:2],
            seed,
            radius=self._radius,
            range=self.stands_in,
            objects=victim.truth,
        )

    def attack(self, frame: SensorFrame, victim: Victim, seed: Seed = 0) -> SensorFrame:
        """See `Attack`; a specific patch needs the victim's intention.

        A patch that was trained against other weights of the same detector is reported, once.
        """
        _report_other_weights(self._patch.card, victim.detector)
        return paste_on_frame(frame, self._patch.pixels, self.placed(frame, victim, seed))

    @property
    def _patch(self) -> Patch:
        assert isinstance(self.patch, Patch), "names and files are resolved at the beginning"
        return self.patch

    @property
    def _radius(self) -> float:
        return self._patch.radius if self.radius is None else self.radius


def _report_other_weights(card: PatchCard | None, detector: Any) -> None:
    name = getattr(detector, "network_name", getattr(detector, "name", None))
    trained = card.detectors.get(name) if card is not None and isinstance(name, str) else None
    if trained is None or trained == (today := weights_hash(detector)):
        return
    message = (
        f"the patch was trained against other weights of {name} ({trained[:8]}) than it is used"
        f" against ({str(today)[:8]}): it is a transferred attack.  `avsec attack patch` trains one"
        " against these."
    )
    if message not in _REPORTED:
        _REPORTED.add(message)
        _LOG.warning(message)
