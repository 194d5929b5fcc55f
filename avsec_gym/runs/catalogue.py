"""Every experiment by its name; nothing of it is imported before it is asked for.

A package adds its own by an entry point of the group ``avsec_gym.experiments``: the experiment's
name, and its place, ``my_package.my_module:MY_EXPERIMENT``.
"""

from __future__ import annotations

import logging
from importlib import import_module, metadata
from typing import Any

from avsec_gym.errors import ConfigurationError
from avsec_gym.runs.experiment import Experiment
from avsec_gym.suggestions import unknown_name

GROUP = "avsec_gym.experiments"
"""Entry points by which packages add experiments."""
_LOG = logging.getLogger(__name__)

EXPERIMENTS: dict[str, str] = {
    "demo": "avsec_gym.experiments.demo.experiment:DEMO",
    "pipeline": "avsec_gym.experiments.pipeline_episodes:PIPELINE",
    "identification": "avsec_gym.experiments.chapter3.experiments:IDENTIFICATION",
    "five_sensors": "avsec_gym.experiments.chapter3.experiments:FIVE_SENSORS",
    "adaptive_attacks": "avsec_gym.experiments.chapter3.experiments:ADAPTIVE_ATTACKS",
    "object_level": "avsec_gym.experiments.chapter3.experiments:OBJECT_LEVEL",
    "impact": "avsec_gym.experiments.chapter3.experiments:IMPACT",
    "believed": "avsec_gym.experiments.chapter3.experiments:BELIEVED",
    "sensitivity": "avsec_gym.experiments.chapter3.experiments:SENSITIVITY",
    "diagrams": "avsec_gym.experiments.chapter3.experiments:DIAGRAMS",
    "localisation": "avsec_gym.experiments.chapter3.experiments:LOCALISATION",
    "defence": "avsec_gym.experiments.chapter3.defence.defended_episodes:DEFENCE",
    "chapter4": "avsec_gym.experiments.chapter4.experiments:CHAPTER_4",
    "joined_identification": "avsec_gym.experiments.chapter4.joined.cells:JOINED",
    "connected_recovery": "avsec_gym.experiments.chapter4.recovery.cells:RECOVERY",
    "chapter4_drives": "avsec_gym.experiments.chapter4.drives.experiment:CHAPTER_4_DRIVES",
} | {
    name: f"avsec_gym.experiments.chapter5.experiments:{attribute}"
    for name, attribute in {
        "chapter5": "CHAPTER_5",
        "perturbation": "PERTURBATION",
        "patch": "PATCH",
        "joint_patch": "JOINT_PATCH",
        "unattacked": "UNATTACKED_EPISODES",
        "planners": "PLANNERS",
        "inputs": "INPUTS",
        "ghost_positions": "GHOST_POSITIONS",
        "texture": "TEXTURE_REPLACEMENT",
        "feature_spread": "FEATURE_SPREAD",
        "without_pyramid": "PYRAMID_ABLATION",
        "controls": "CONTROLS",
        "stronger_perturbations": "STRONGER_PERTURBATIONS",
    }.items()
}
"""Name -> ``"module:attribute"`` of this package's, the demo and any parts first, then in the order
of the thesis."""


def known_experiments() -> dict[str, str]:
    """`EXPERIMENTS`, and after them those of installed packages; of two of one name, the first."""
    known = dict(EXPERIMENTS)
    for point in metadata.entry_points(group=GROUP):
        if known.setdefault(point.name, point.value) != point.value:
            _LOG.warning(
                "the experiment %s of %s is left out: there is one of that name already",
                *(point.name, point.value),
            )
    return known


def importable_experiments() -> tuple[list[Experiment], list[str]]:
    """All known experiments, and a sentence about each that cannot be had."""
    found, problems = [], []
    for name in known_experiments():
        try:
            found.append(experiment(name))
        except Exception as error:
            # A broken package must not take the others, or this project, with it.
            if name in EXPERIMENTS:
                raise
            problems.append(f"the experiment {name} of another package is left out: {error}")
    return found, problems


def experiment(name: str) -> Experiment:
    """The experiment of a name, or of any importable place.

    Args:
        name: One of `known_experiments`, or ``"my_package.my_module:MY_EXPERIMENT"``, which needs
            no entry point.

    Raises:
        ConfigurationError: There is none.
    """
    known = {} if ":" in name else known_experiments()
    if ":" not in name and name not in known:
        raise ConfigurationError(
            unknown_name(f"there is no experiment {name!r}", name, known)
            + "; one of your own is named by its place, my_package.my_module:MY_EXPERIMENT"
        )
    found = attribute(known.get(name, name))
    if not isinstance(found, Experiment):
        raise ConfigurationError(f"{name} is no Experiment but {type(found).__name__}")
    return found


def attribute(place: str) -> Any:
    """What stands at ``"module:attribute"``.

    Raises:
        ConfigurationError: No such module, or nothing of that name in it.
    """
    module, _, name = place.partition(":")
    try:
        return getattr(import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        raise ConfigurationError(f"{place} cannot be imported: {error}") from error
