"""Whether anything in a car reads the sensors that an agent attacks: else there is no game."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from avsec_gym.built_in_parts import BUILT_IN, Kind
from avsec_gym.envs.parts import Parts
from avsec_gym.errors import ConfigurationError

CAMERAS, SCAN = "cameras", "LiDAR"
READ = {
    **dict.fromkeys(("dsgn", "stereo_rcnn", "single_image"), CAMERAS),
    **dict.fromkeys(("pixor", "pointrcnn", "scan_obstacles"), SCAN),
}
"""What a detector of the package reads, by its name.

Those that look things up stand for any other one; ``defended`` and ``attacked`` read what the one
within does.
"""
_INSTEAD = {
    CAMERAS: 'a detector of images, such as detector="dsgn", or a validator that compares the'
    ' cameras, such as validator="thresholds"',
    SCAN: 'a detector of scans, such as detector="pixor" or "scan_obstacles", or a validator that'
    ' compares the LiDAR with others, such as validator="thresholds"',
}


def check_read(parts: Parts, detector: Any, attacked: str) -> None:
    """Refuse an attack on what neither the detector nor any other part of the car reads.

    Args:
        parts: The parts of the car.
        detector: The detector as it was given: a name, a dictionary, or a live one.
        attacked: `CAMERAS` or `SCAN`.

    Raises:
        ConfigurationError: The detector reads the other sensors, and there is no other reader.
    """
    # A validator compares all sensors; classifier and selector look at images.
    looking = (parts.classifier, parts.selector) if attacked == CAMERAS else ()
    if parts.validator is not None or any(part is not None for part in looking):
        return
    name = _name(detector)
    if READ.get(name, attacked) != attacked:
        raise ConfigurationError(
            f"the attack is on the {attacked}, which nothing in this car reads: the detector"
            f" {name!r} reads the {READ[name]}, and there is no validator. Give"
            f" {_INSTEAD[attacked]}"
        )


def _name(detector: Any) -> str:
    """The name of a detector of the package, the innermost one; empty of another."""
    if isinstance(detector, Mapping):
        inner = detector.get("detector")
        if inner is not None and detector.get("name") != "single_image":
            return _name(inner)
        detector = detector.get("name")
    if isinstance(detector, str):
        return detector
    place = f"{type(detector).__module__}:{type(detector).__qualname__}"
    known = BUILT_IN.items()
    found = [name for (kind, name), (own, _) in known if kind == Kind.DETECTOR and own == place]
    return found[0] if found else ""
