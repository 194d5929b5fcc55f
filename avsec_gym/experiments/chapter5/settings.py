"""The settings of chapter 5: the names that results of its attacks are stored under.

``thesis_pgd-0.4``: steps of 0.4 grey levels, n = 1..4 (the strength), not projected;
``noise-0.4``: its control, as large as four such steps; ``patch-random`` and ``patch-specific``:
the detector's own patch; ``joint-...``: the one trained for both detectors; ``grey-...``: the
patch's control;
``texture``: the side area looks like the road, attacked by ``thesis_pgd-1`` as well.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from avsec_gym.scenario.intention import Intention

DETECTORS = ("dsgn", "stereo_rcnn")
DSGN = DETECTORS[0]
WITHOUT_PYRAMID = "dsgn_without_pyramid"
"""DSGN without its spatial pyramid pooling: an ablation, no detector of the chapter's question."""
UNATTACKED = "unattacked"
ALPHAS = (0.4, 1.0)
STEPS = 4
THESIS_PGD = "thesis_pgd"
PERTURBATIONS = tuple(f"{THESIS_PGD}-{alpha:g}" for alpha in ALPHAS)
NOISES = tuple(f"noise-{alpha:g}" for alpha in ALPHAS)
PLACEMENTS = ("random", "specific")
PATCHES, JOINT_PATCHES, GREY_PATCHES = (
    tuple(f"{kind}-{placement}" for placement in PLACEMENTS) for kind in ("patch", "joint", "grey")
)
TEXTURE = "texture"
TEXTURE_ATTACKED = f"{TEXTURE}-{THESIS_PGD}-1"
ATTACKS = (
    UNATTACKED,
    *PERTURBATIONS,
    *PATCHES,
    *JOINT_PATCHES,
    TEXTURE,
    TEXTURE_ATTACKED,
    *NOISES,
    *GREY_PATCHES,
)
"""All attacks, in the order of tables."""
FAMILIES: Mapping[str, tuple[str, ...]] = {
    "perturbations": PERTURBATIONS,
    "patches": PATCHES + JOINT_PATCHES,
}
"""Attacks that work in the same way: by what they change of the images."""
WHOLE_LEVELS = "8-bit"
Options = Mapping[str, Any]
"""Options of a run, by the names of `avsec_gym.experiments.chapter5.scenes.OPTIONS`."""


def setting(detector: str, attack: str, *, whole_levels: bool = False) -> str:
    """The setting of results; the strength stands beside it."""
    return f"{detector} {attack} {WHOLE_LEVELS}" if whole_levels else f"{detector} {attack}"


def specific(attack: str, intention: Intention) -> str:
    """A specific attack in the setting of detections, which depend on the intention."""
    return f"{attack}-{intention}"


def thesis_setting(attack: str, strength: float) -> str:
    """The same in the thesis' tables, see `avsec_gym.experiments.thesis`."""
    return f"{attack}-{strength:g}" if attack in PERTURBATIONS and strength else attack
