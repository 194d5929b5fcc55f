"""The experiments of chapter 3, by what they need to be done."""

from __future__ import annotations

from avsec_gym.experiments.chapter3.diagrams.evidence_cells import diagram_cells, diagram_inputs
from avsec_gym.experiments.chapter3.diagrams.settings import DIAGRAM_OPTIONS
from avsec_gym.experiments.chapter3.identification.adaptive_attacks import adaptive_cells
from avsec_gym.experiments.chapter3.identification.five_sensors import five_cells, five_inputs
from avsec_gym.experiments.chapter3.identification.state_evidence_cells import (
    evidence_cells,
    evidence_inputs,
)
from avsec_gym.experiments.chapter3.localisation.repaired_frames import (
    LOCALISATION_OPTIONS,
    localisation_cells,
    localisation_inputs,
)
from avsec_gym.experiments.chapter3.objects.attack_sizes import (
    SIZE_OPTIONS,
    size_cells,
    size_inputs,
)
from avsec_gym.experiments.chapter3.objects.believed_points import (
    BELIEVED_OPTIONS,
    believed_cells,
    believed_inputs,
)
from avsec_gym.experiments.chapter3.objects.sensor_detections import (
    DETECTION_OPTIONS,
    detection_cells,
    detection_inputs,
)
from avsec_gym.experiments.chapter3.recordings import OPTIONS, USUAL_COUNT
from avsec_gym.experiments.procedural_frames import PROCEDURAL
from avsec_gym.runs.experiment import Configuration, Experiment

_USUAL = Configuration(PROCEDURAL, USUAL_COUNT)
_IDENTIFICATION = "avsec_gym.experiments.chapter3.identification.section:findings"
_OPTICAL = "avsec_gym.experiments.chapter3.objects.section:findings"

IDENTIFICATION = Experiment(
    "identification",
    "Is an attack on LiDAR or cameras detected, and are the attacked sensors named?",
    "Tables 3.1 and 3.2, figures 3.5 to 3.10",
    evidence_cells,
    evidence_inputs,
    OPTIONS,
    _USUAL,
    section=_IDENTIFICATION,
)

FIVE_SENSORS = Experiment(
    "five_sensors",
    "Are two attacked ones of five sensors named?",
    "Section 3.4, beyond one of four",
    five_cells,
    five_inputs,
    OPTIONS,
    Configuration(PROCEDURAL, 200),
    section="avsec_gym.experiments.chapter3.identification.five_sensors_section:findings",
)

ADAPTIVE_ATTACKS = Experiment(
    "adaptive_attacks",
    "What stays undetected where the attacker knows the method?",
    "beyond it",
    adaptive_cells,
    evidence_inputs,
    OPTIONS,
    _USUAL,
    section=_IDENTIFICATION,
)

OBJECT_LEVEL = Experiment(
    "object_level",
    "Do mismatches between two sensors' objects reveal that one of them is attacked?",
    "Table 3.1, baseline",
    detection_cells,
    detection_inputs,
    DETECTION_OPTIONS,
    _USUAL,
    section=_OPTICAL,
)

IMPACT = Experiment(
    "impact",
    "Is a bogus return taken for an obstacle, and what does a facula cost a detector?",
    "Section 3.2.4",
    detection_cells,
    detection_inputs,
    DETECTION_OPTIONS,
    _USUAL,
    section=_OPTICAL,
)

BELIEVED = Experiment(
    "believed",
    "Which bogus points does a detector take for an obstacle?",
    "Section 3.2.4, and beyond it",
    believed_cells,
    believed_inputs,
    BELIEVED_OPTIONS,
    _USUAL,
    section=_OPTICAL,
)

SENSITIVITY = Experiment(
    "sensitivity",
    "Are attacks detected that are large enough to harm a detector?",
    "Figures 3.11 and 3.12",
    size_cells,
    size_inputs,
    SIZE_OPTIONS,
    _USUAL,
    section=_OPTICAL,
)

LOCALISATION = Experiment(
    "localisation",
    "Is the damage found in attacked sensors, and how well is it repaired?",
    "Section 6.2, future work",
    localisation_cells,
    localisation_inputs,
    LOCALISATION_OPTIONS,
    _USUAL,
    section="avsec_gym.experiments.chapter3.localisation.section:findings",
)

DIAGRAMS = Experiment(
    "diagrams",
    "How do detection and belief depend on density, depth, strength and matcher?",
    "Table 3.1, figures 3.11 and 3.12, section 3.2.4, over what these leave open",
    diagram_cells,
    diagram_inputs,
    DIAGRAM_OPTIONS,
    Configuration(PROCEDURAL, 200),
    section="avsec_gym.experiments.chapter3.diagrams.section:findings",
)
