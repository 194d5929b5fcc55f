"""The experiments of chapter 5, by what they need to be done."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from avsec_gym.experiments.chapter5.attacked_cells import (
    attacked_cells,
    attacked_inputs,
    stronger_cells,
)
from avsec_gym.experiments.chapter5.patch_spreads import spread_cells, spread_inputs
from avsec_gym.experiments.chapter5.scenes import OPTIONS, PYRAMID_OPTIONS
from avsec_gym.experiments.chapter5.settings import (
    DETECTORS,
    DSGN,
    GREY_PATCHES,
    JOINT_PATCHES,
    NOISES,
    PATCHES,
    PERTURBATIONS,
    TEXTURE,
    UNATTACKED,
    WITHOUT_PYRAMID,
)
from avsec_gym.experiments.chapter5.stronger_attacks import ALL, STRONGER_OPTIONS
from avsec_gym.experiments.chapter5.trained import patches_there
from avsec_gym.experiments.chapter5.true_episodes import true_cells, true_inputs
from avsec_gym.runs.experiment import Cell, Configuration, Experiment

SECTION = "avsec_gym.experiments.chapter5.section.findings:findings"


def _with_truth(configuration: Configuration, attacks: Sequence[str]) -> list[Cell]:
    return [*true_cells(configuration), *attacked_cells(configuration, attacks)]


def _attacked(name: str, question: str, thesis: str, *attacks: str) -> Experiment:
    return Experiment(
        name,
        question,
        thesis,
        partial(attacked_cells, attacks=(UNATTACKED, *attacks)),
        attacked_inputs,
        OPTIONS,
        section=SECTION,
    )


def _pyramid_cells(configuration: Configuration) -> list[Cell]:
    """Under the patches that are there for both networks; none without weights.

    Missing weights are reported when the inputs are asked for.
    """
    options = {**PYRAMID_OPTIONS, **configuration.options}
    if not options[WITHOUT_PYRAMID]:
        return []
    kinds = set(patches_there(DSGN, options)) & set(patches_there(WITHOUT_PYRAMID, options))
    patches = [patch for patch in PATCHES + JOINT_PATCHES if patch.partition("-")[0] in kinds]
    both = (DSGN, WITHOUT_PYRAMID)
    episodes = attacked_cells(configuration, (UNATTACKED, *patches), both)
    return [*episodes, *spread_cells(configuration, both)]


def _stronger_cells(configuration: Configuration) -> list[Cell]:
    """All stronger attacks where the options name none, beside the unattacked detectors."""
    options = {**STRONGER_OPTIONS, **configuration.options}
    asked = replace(configuration, options=options | {"stronger": options["stronger"] or ALL})
    cells = stronger_cells(asked)
    drawn = {cell.arguments["scenario"] for cell in cells}
    unattacked = attacked_cells(configuration, (UNATTACKED,))
    return [*(cell for cell in unattacked if cell.arguments["scenario"] in drawn), *cells]


def _chapter_5_cells(configuration: Configuration) -> list[Cell]:
    """Feature maps last: they take their time, and the answer needs none of them.

    Stronger attacks are there only where the options name them.
    """
    attacks = (
        UNATTACKED,
        *PERTURBATIONS,
        *PATCHES,
        *JOINT_PATCHES,
        TEXTURE,
        *NOISES,
        *GREY_PATCHES,
    )
    return [
        *_with_truth(configuration, attacks),
        *stronger_cells(configuration),
        *spread_cells(configuration, DETECTORS),
    ]


PLANNERS = Experiment(
    "planners",
    "Does it matter which search plans, A* or GBFS?",
    "Table 5.6",
    true_cells,
    true_inputs,
    OPTIONS,
    section=SECTION,
)
UNATTACKED_EPISODES = Experiment(
    "unattacked",
    "What do a detector's own errors cost without an attack?",
    "Tables 5.1 to 5.4, U",
    partial(attacked_cells, attacks=(UNATTACKED,)),
    attacked_inputs,
    OPTIONS,
    section=SECTION,
)
INPUTS = Experiment(
    "inputs",
    "What do errors of detection cost, and what do attacks cost?",
    "Table 5.7",
    partial(_with_truth, attacks=(UNATTACKED, "thesis_pgd-1", "patch-random")),
    attacked_inputs,
    OPTIONS,
    section=SECTION,
)
PERTURBATION = _attacked(
    "perturbation",
    "What do perturbations of growing strength do to precision, and to driving safety?",
    "Figures 5.3 and 5.4, Tables 5.1 and 5.2",
    *PERTURBATIONS,
)
PATCH = _attacked(
    "patch",
    "What does a patch do to precision, and to driving safety, by where it stands?",
    "Tables 5.3 to 5.5",
    *PATCHES,
)
JOINT_PATCH = _attacked(
    "joint_patch",
    "What does one patch do that was trained for both detectors?",
    "Section 5.5.2",
    *JOINT_PATCHES,
)
TEXTURE_REPLACEMENT = _attacked(
    "texture",
    "Are ghosts beside the road because the texture there is more complex?",
    "Figures 5.6 and 5.7",
    "thesis_pgd-1",
    TEXTURE,
)
GHOST_POSITIONS = _attacked(
    "ghost_positions",
    "Do perturbations put ghosts beside the road, more than chance would?",
    "Section 5.5.1",
    *PERTURBATIONS,
    TEXTURE,
    *NOISES,
)
FEATURE_SPREAD = Experiment(
    "feature_spread",
    "How far does a patch spread through the feature maps of each detector?",
    "Figure 5.8",
    spread_cells,
    spread_inputs,
    PYRAMID_OPTIONS,
    section=SECTION,
)
PYRAMID_ABLATION = Experiment(
    "without_pyramid",
    "Does its spatial pyramid pooling protect DSGN from patches?",
    "Section 5.5.2",
    _pyramid_cells,
    partial(attacked_inputs, detectors=(DSGN, WITHOUT_PYRAMID)),
    PYRAMID_OPTIONS,
    section=SECTION,
)
CONTROLS = _attacked(
    "controls",
    "Do random noise and a grey disc of the same size do the same?",
    "",
    *NOISES,
    *GREY_PATCHES,
)
STRONGER_PERTURBATIONS = Experiment(
    "stronger_perturbations",
    "Do more steps, the class alone, or a mean over noise take what the thesis' perturbations do"
    " not?",
    "",
    _stronger_cells,
    attacked_inputs,
    {**OPTIONS, **STRONGER_OPTIONS},
    section=SECTION,
)
CHAPTER_5 = Experiment(
    "chapter5",
    "Does a detector's loss of precision under attack say anything about driving safety?",
    "Chapter 5",
    _chapter_5_cells,
    attacked_inputs,
    {**OPTIONS, **STRONGER_OPTIONS},
    section=SECTION,
)
