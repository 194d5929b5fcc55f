"""Which file of weights a detector is made of, known without making it, and without torch."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from avsec_gym.storage.regular_files import is_file, read_bytes

_MOST_BYTES = 1 << 30


def weights_file_hash(detector: Any) -> str | None:
    """SHA-256 of the file that a detector's weights are from; None: it has none that is known.

    Args:
        detector: The detector as `avsec detect` takes it: a name, or JSON with arguments.

    Example:
        >>> weights_file_hash("stereo_rcnn") is None, weights_file_hash("point_gnn") is None
        (False, True)
    """
    given = detector if isinstance(detector, Mapping) else {"name": detector}
    weights = given.get("weights", "shipped")
    if weights == "shipped":
        preset = given.get("configuration", "small")
        weights = Path(__file__).parent / f"{given.get('name')}_{preset}.safetensors"
    if not isinstance(weights, str | Path) or not is_file(Path(weights)):
        return None
    return hashlib.sha256(read_bytes(Path(weights), most=_MOST_BYTES)).hexdigest()
