"""The experiments of chapter 3, by what they need to be done."""

from __future__ import annotations

from avsec_gym.experiments.chapter3.recordings import OPTIONS, USUAL_COUNT
from avsec_gym.experiments.chapter3.state_evidence_cells import evidence_cells, evidence_inputs
from avsec_gym.experiments.experiment import Configuration, Experiment
from avsec_gym.experiments.procedural_frames import PROCEDURAL

IDENTIFICATION = Experiment(
    "identification",
    "Is an attack on LiDAR or cameras noticed, and are the attacked sensors named?",
    "Tables 3.1 to 3.4",
    evidence_cells,
    evidence_inputs,
    OPTIONS,
    Configuration(PROCEDURAL, USUAL_COUNT),
)
