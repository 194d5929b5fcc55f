"""The demo: chapter 5 in small, both detectors in a few contested scenes, in minutes."""

from __future__ import annotations

from avsec_gym.experiments.chapter5.attacked_cells import attacked_cells, attacked_inputs
from avsec_gym.experiments.chapter5.scenes import OPTIONS
from avsec_gym.experiments.chapter5.settings import (
    DETECTORS,
    PATCHES,
    PERTURBATIONS,
    UNATTACKED,
    Options,
)
from avsec_gym.experiments.chapter5.trained import patches_there
from avsec_gym.experiments.chapter5.true_episodes import true_cells
from avsec_gym.experiments.procedural_frames import CONTESTED
from avsec_gym.runs.experiment import Cell, Configuration, Experiment

PATCH = PATCHES[0]
"""The detector's own patch, in a random place."""
SCENES = 3
"""As many scenes as are done within three minutes on two cores, from nothing."""
FULL_REPORT = 100
"""The fewest scenes with which a demo is a report: rates tell how often something happens,
precision has intervals, and the validator also drives without a laser."""


def unpatched(options: Options) -> tuple[str, ...]:
    """Detectors that there is no trained patch against: the demo leaves their patch out."""
    there = {**OPTIONS, **options}
    return tuple(name for name in DETECTORS if "patch" not in patches_there(name, there))


def _demo_cells(configuration: Configuration) -> list[Cell]:
    without = unpatched(configuration.options)
    cells = true_cells(configuration)
    for detector in DETECTORS:
        patches = () if detector in without else (PATCH,)
        attacks = (UNATTACKED, PERTURBATIONS[-1], *patches)
        cells += attacked_cells(configuration, attacks, (detector,))
    return cells


DEMO = Experiment(
    "demo",
    "What does an attacked car still see, and does it still drive safely?",
    "Chapter 5",
    _demo_cells,
    attacked_inputs,
    {**OPTIONS, "sanity_sheet": False},
    Configuration(CONTESTED, SCENES),
    section="avsec_gym.experiments.demo.section:findings",
    alone=True,
)
