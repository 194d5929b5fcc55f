"""Names that results had before, and the names that stand for them now.

Results outlive the code that made them.  A run that was made under an old name is read, reported
and continued under the new one.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

EXPERIMENTS: Mapping[str, str] = {"knowing": "adaptive_attacks"}
"""Old name of an experiment -> its name."""

_CHAPTER_3 = "avsec_gym.experiments.chapter3"
WORKS: Mapping[str, str] = {
    f"{_CHAPTER_3}.identification.knowing_attackers:KnowingAttackers": (
        f"{_CHAPTER_3}.identification.adaptive_attacks:AdaptiveAttacks"
    ),
    f"{_CHAPTER_3}.localisation.repaired_moments:RepairedMoments": (
        f"{_CHAPTER_3}.localisation.repaired_frames:RepairedFrames"
    ),
}
"""Old place of a work -> its place.  A cell keeps the id that it had under the old one."""

KEYS: Mapping[str, Mapping[str, str]] = {
    "identification": {
        "moments": "frames",
        "noticed": "detected",
        "noticed_by_error": "detected_by_error",
        "told": "reported",
        "honesty": "calibration",
        "verdicts": "statuses",
        "said": "predicted",
        "was": "observed",
        **EXPERIMENTS,
    },
    "five_sensors": {"moments": "frames", "told": "reported"},
    "object_level": {"moments": "frames"},
    "impact": {"moments": "frames"},
    "sensitivity": {"moments": "frames"},
    "localisation": {"moments": "frames", "moment": "frame"},
    "other_pairs": {"moments": "frames"},
    "identification_real": {"moments": "frames"},
    "shipped_fits": {"nobody": "no attack"},
}
"""By experiment or study: old key of its figures -> the key."""


def with_new_keys(figures: Any, renamed: Mapping[str, str]) -> Any:
    """The figures of an earlier release under the keys of this one; values stay as they are.

    Args:
        figures: What JSON can state.
        renamed: Old key -> new key, one of `KEYS`.

    Example:
        >>> with_new_keys({"rows": [{"told": 0.5}]}, KEYS["five_sensors"])
        {'rows': [{'reported': 0.5}]}
    """
    if isinstance(figures, dict):
        return {
            renamed.get(key, key): with_new_keys(value, renamed) for key, value in figures.items()
        }
    if isinstance(figures, list):
        return [with_new_keys(value, renamed) for value in figures]
    return figures


def first_place(work: str) -> str:
    """The place where a work stood first, on which the ids of its cells depend.

    Args:
        work: The place where it stands now.
    """
    return _FIRST_PLACES.get(work, work)


_FIRST_PLACES = {new: old for old, new in WORKS.items()}
