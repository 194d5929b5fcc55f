"""The experiment on drives of connected vehicles, by what it needs to be done."""

from __future__ import annotations

from avsec_gym.experiments.chapter4.drives.drive_cells import (
    USUAL_DRIVES,
    drive_cells,
    drive_inputs,
)
from avsec_gym.experiments.chapter4.drives.settings import OPTIONS
from avsec_gym.experiments.procedural_frames import PROCEDURAL
from avsec_gym.runs.experiment import Configuration, Experiment

CHAPTER_4_DRIVES = Experiment(
    "chapter4_drives",
    "What do connected vehicles detect over a second of successive instants?",
    "",
    drive_cells,
    drive_inputs,
    OPTIONS,
    Configuration(PROCEDURAL, USUAL_DRIVES),
    section="avsec_gym.experiments.chapter4.drives.section:findings",
)
