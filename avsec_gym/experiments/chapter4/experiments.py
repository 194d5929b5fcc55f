"""The experiment of chapter 4, by what it needs to be done."""

from __future__ import annotations

from avsec_gym.experiments.chapter4.instant_cells import (
    USUAL_COUNT,
    connected_cells,
    connected_inputs,
)
from avsec_gym.experiments.chapter4.settings import OPTIONS
from avsec_gym.experiments.procedural_frames import PROCEDURAL
from avsec_gym.runs.experiment import Configuration, Experiment

CHAPTER_4 = Experiment(
    "chapter4",
    "Do connected vehicles detect that one of them is lied to by its LiDAR?",
    "Section 4.5, figures 4a and 4b",
    connected_cells,
    connected_inputs,
    OPTIONS,
    Configuration(PROCEDURAL, USUAL_COUNT),
    section="avsec_gym.experiments.chapter4.section:findings",
)
