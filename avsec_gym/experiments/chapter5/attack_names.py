"""The names of detectors and attacks for readers."""

from __future__ import annotations

from collections.abc import Callable

from avsec_gym.experiments.chapter5.settings import (
    NOISES,
    PERTURBATIONS,
    STEPS,
    TEXTURE,
    TEXTURE_ATTACKED,
    UNATTACKED,
    WITHOUT_PYRAMID,
)
from avsec_gym.experiments.chapter5.stronger_attacks import STRONGER
from avsec_gym.experiments.thesis import NAMES

AttackName = Callable[[str, float, bool], str]
"""Words an attack by its key, its strength, and whether pixels were rounded, as `attack_name`."""
_STRONGER = {attack.name: attack.words for attack in STRONGER}
_PATCHES = {"patch": "patch", "joint": "joint patch", "grey": "grey disc"}


def detector_name(detector: str) -> str:
    """The detector's name as in the thesis.

    Example:
        >>> detector_name("stereo_rcnn")
        'Stereo R-CNN'
    """
    return {**NAMES, WITHOUT_PYRAMID: "DSGN without SPP"}.get(detector, detector)


def attack_name(attack: str, strength: float = 0.0, whole_levels: bool = False) -> str:
    """The attack's name in words.

    Args:
        attack: The key of the attack, see `avsec_gym.experiments.chapter5.settings`, or one of
            `STRONGER`.
        strength: Steps, n; 0: whatever strength.
        whole_levels: Whether pixels were rounded.

    Example:
        >>> attack_name("thesis_pgd-0.4", 3), attack_name("patch-random"), attack_name("noise-1")
        ('thesis PGD α 0.4, n 3', 'random patch', 'noise of 4 grey levels')
    """
    kind, _, rest = attack.partition("-")
    if attack == UNATTACKED:
        name = "unattacked"
    elif attack in _STRONGER:
        name = _STRONGER[attack]
    elif attack in PERTURBATIONS:
        name = f"thesis PGD α {rest}"
    elif attack in NOISES:
        name = f"noise of {STEPS * float(rest):g} grey levels"
    elif attack == TEXTURE:
        name = "retextured side area"
    elif attack == TEXTURE_ATTACKED:
        name = "retextured, thesis PGD α 1"
    elif kind in _PATCHES:
        name = f"{rest} {_PATCHES[kind]}"
    else:
        name = attack
    if strength and attack not in NOISES:
        name += f", n {strength:g}"
    return f"{name}, 8 bits" if whole_levels else name
