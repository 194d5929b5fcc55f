"""The demo's patch in words: what it is called, and what a grey one does in its place."""

from __future__ import annotations

from collections.abc import Iterable

from avsec_gym.attacks.patch_files import load_patch
from avsec_gym.drawing.page_table import number
from avsec_gym.errors import DataError
from avsec_gym.experiments.chapter5.attack_names import attack_name, detector_name
from avsec_gym.experiments.chapter5.scenes import OPTIONS
from avsec_gym.experiments.chapter5.trained import patch_file
from avsec_gym.experiments.demo.experiment import PATCH
from avsec_gym.runs.run_folder import RunFolder

_ALIKE = 0.05
"""Share of the larger loss by which two losses differ at most that count as about the same."""


def demo_attack_name(attack: str, strength: float = 0.0, whole_levels: bool = False) -> str:
    """The attack's name in words, as `attack_name`; of the patch, what is random about it.

    Args:
        attack: The key of the attack.
        strength: Steps, n; 0: whatever strength.
        whole_levels: Whether pixels were rounded.

    Example:
        >>> demo_attack_name("patch-random"), demo_attack_name("unattacked")
        ('trained patch, random place', 'unattacked')
    """
    if attack == PATCH:
        return "trained patch, random place"
    return attack_name(attack, strength, whole_levels)


def grey_in_words(run: RunFolder, detectors: Iterable[str]) -> str:
    """A sentence on a grey patch as the control of trained ones; empty where no card states it.

    Args:
        run: The run; only cards of the patches that it was made with count.
        detectors: The detectors that a trained patch was shown to.
    """
    clauses = [
        _losses_in_words(detector, *losses)
        for detector in detectors
        if (losses := _losses(run, detector)) is not None
    ]
    if not clauses:
        return ""
    return f"A grey patch is the control, by the loss that training lowers: {'; '.join(clauses)}."


def _losses_in_words(detector: str, grey: float, trained: float) -> str:
    is_alike = abs(trained - grey) <= _ALIKE * max(abs(trained), abs(grey))
    alike = ", so that grey does about the same" if is_alike else ""
    losses = f"{number(grey, digits=3)} grey and {number(trained, digits=3)} trained"
    return f"against {detector_name(detector)} {losses}{alike}"


def _losses(run: RunFolder, detector: str) -> tuple[float, float] | None:
    """The losses of a grey patch and of the trained one, by the card of the run's own patch."""
    path = patch_file("patch", detector, {**OPTIONS, **run.configuration.options})
    used = run.manifest["inputs"].get(f"patch {path.stem}")
    try:
        card = load_patch(path).card
    except DataError:  # It was taken away since.
        return None
    if card is None or used is None or card.sha256 != used["sha256"]:
        return None
    grey, trained = (card.losses.get(kind, {}).get(detector) for kind in ("grey", "patch"))
    return None if grey is None or trained is None else (grey, trained)
