"""All figures of chapter 5 that a run has: its sections show them, and its JSON holds them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from avsec_gym.experiments.chapter5.contested_scenes import ContestedFigures, contested_figures
from avsec_gym.experiments.chapter5.controls import (
    ControlRow,
    RoundingRow,
    TrendRow,
    control_rows,
    rounding_rows,
    trend_rows,
)
from avsec_gym.experiments.chapter5.decoupling import Decoupling, decoupling
from avsec_gym.experiments.chapter5.families import FamilyFigures, family_figures
from avsec_gym.experiments.chapter5.flips import Flip, flips
from avsec_gym.experiments.chapter5.ghost_shares import GhostRow, ghost_rows
from avsec_gym.experiments.chapter5.outcomes import Condition, Outcomes
from avsec_gym.experiments.chapter5.patch_effects import PatchEffectRow, patch_effect_rows
from avsec_gym.experiments.chapter5.pyramid import PyramidRow, pyramid_rows
from avsec_gym.experiments.chapter5.scenes import OPTIONS, scenes_of
from avsec_gym.experiments.chapter5.seen import SeenRow, seen_rows
from avsec_gym.experiments.chapter5.stronger_rows import StrongerRows, stronger_rows
from avsec_gym.experiments.chapter5.tables import (
    InputRow,
    PlacementRow,
    PlannerRow,
    PrecisionRow,
    SafetyRow,
    input_rows,
    placement_rows,
    planner_rows,
    precision_rows,
    safety_rows,
)
from avsec_gym.experiments.json_rows import FLAT, OPTIONAL, keyed
from avsec_gym.progress import Progress, no_progress
from avsec_gym.runs.run_folder import RunFolder


@dataclass(frozen=True)
class LeftOutRow:
    """A condition that too few scenarios were done for.

    Args:
        condition: The detector under the attack.
        scenarios: Number of its scenarios.
    """

    condition: Condition
    scenarios: int


@dataclass(frozen=True)
class AttackFigures:
    """The figures of a run that has detectors.

    Args:
        decoupling: Losses of precision and of safety, and how far they go together.
        precision: Figure 5.3 and table 5.3.
        safety: Tables 5.1, 5.2 and 5.4.
        inputs: Table 5.7.
        placements: Table 5.5.
        seen: Cars and ghosts that are seen.
        ghosts: Places of ghosts.
        pyramid: DSGN with its spatial pyramid pooling and without.
        patch_effects: Ghosts of patches, and what they do.
        controls: The sanity sheet.
        trends: Slopes over the steps of perturbations.
        rounding: Attacks in whole grey levels.
        flips: Episodes that became unsafe.
        families: Losses by family of attacks, and the exchange rate between them.
        contested: Losses where it matters what a car sees; None: no scenario is contested.
        stronger: Perturbations stronger than the thesis'; None: the run has none.
    """

    decoupling: Decoupling
    precision: Sequence[PrecisionRow]
    safety: Sequence[SafetyRow]
    inputs: Sequence[InputRow]
    placements: Sequence[PlacementRow] = field(metadata=keyed("intentions"))
    seen: Sequence[SeenRow]
    ghosts: Sequence[GhostRow]
    pyramid: Sequence[PyramidRow]
    patch_effects: Sequence[PatchEffectRow]
    controls: Sequence[ControlRow]
    trends: Sequence[TrendRow]
    rounding: Sequence[RoundingRow]
    flips: Sequence[Flip]
    families: FamilyFigures
    contested: ContestedFigures | None
    stronger: StrongerRows | None = field(metadata=OPTIONAL, default=None)


@dataclass(frozen=True)
class ChapterFigures:
    """The figures of a run of chapter 5, as far as it has any.

    Args:
        scenarios: Number of scenarios that every condition was done for.
        left_out: Conditions with too few scenarios.
        planners: Table 5.6.
        of_attacks: The figures of detectors; None: the run has none.
    """

    scenarios: int
    left_out: Sequence[LeftOutRow]
    planners: Sequence[PlannerRow]
    of_attacks: AttackFigures | None = field(metadata=FLAT, default=None)


def chapter_figures(
    run: RunFolder, outcomes: Outcomes, on_progress: Progress = no_progress
) -> ChapterFigures:
    """Measure all of them.

    Args:
        run: The run.
        outcomes: The run's outcomes.
        on_progress: Function that gets the number of slow parts that are done, and of all.

    Raises:
        DataError: Data of the run's scenes are not where they were.
    """
    conditions = outcomes.conditions if outcomes.scenarios else ()
    scenarios = len(outcomes.scenarios)
    slow = len(conditions) + 2 * scenarios
    for number, condition in enumerate(conditions):
        # The slow part, done first so that it can be watched; the outcomes keep it.
        on_progress(number, slow)
        for intention in outcomes.looks(condition):
            outcomes.precision(condition, intention)
    left_out = [LeftOutRow(*found) for found in outcomes.left_out.items()]
    planners = planner_rows(outcomes)
    if not conditions:
        return ChapterFigures(len(outcomes.scenarios), left_out, planners)
    threshold = {**OPTIONS, **run.configuration.options}["score_threshold"]
    scenes = scenes_of(run.configuration)
    of_attacks = AttackFigures(
        decoupling=decoupling(outcomes),
        precision=precision_rows(outcomes),
        safety=safety_rows(outcomes),
        inputs=input_rows(outcomes),
        placements=placement_rows(outcomes),
        seen=seen_rows(outcomes, threshold),
        ghosts=ghost_rows(
            outcomes,
            scenes,
            threshold,
            lambda done, _: on_progress(len(conditions) + done, slow),
        ),
        pyramid=pyramid_rows(run, outcomes.labels),
        patch_effects=patch_effect_rows(outcomes),
        controls=control_rows(outcomes),
        trends=trend_rows(outcomes),
        rounding=rounding_rows(outcomes),
        flips=flips(outcomes),
        families=family_figures(outcomes),
        contested=contested_figures(
            outcomes,
            scenes.scenes.labelled,
            lambda done, _: on_progress(len(conditions) + scenarios + done, slow),
        ),
        stronger=stronger_rows(run, run.configuration, outcomes.labels),
    )
    return ChapterFigures(len(outcomes.scenarios), left_out, planners, of_attacks)
