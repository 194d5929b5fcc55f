"""Where the ghosts of a run are: on the road or beside it, compared with chance (thesis, 5.5.1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from avsec_gym.experiments.chapter5.ghost_positions import (
    GhostCount,
    GhostPlace,
    GhostSummary,
    count_ghosts,
    ghost_summary,
    placed_ghosts,
    visible_areas,
)
from avsec_gym.experiments.chapter5.outcomes import RESAMPLES, Condition, Outcomes
from avsec_gym.experiments.chapter5.scenes import road_view_of
from avsec_gym.experiments.json_rows import FLAT
from avsec_gym.progress import Progress, no_progress
from avsec_gym.scenario.frame_scenes import FrameScenes

_SHOWN = 1000
"""Ghosts of each condition whose positions are given."""


@dataclass(frozen=True)
class GhostRow:
    """The ghosts of a condition.

    Args:
        condition: The detector under the attack.
        summary: The places of its ghosts, in numbers.
        positions: Metres to the right and ahead of the camera of its first ghosts, by `GhostPlace`.
    """

    condition: Condition
    summary: GhostSummary = field(metadata=FLAT)
    positions: Mapping[str, Sequence[Sequence[float]]]


def ghost_rows(
    outcomes: Outcomes,
    scenes: FrameScenes,
    threshold: float,
    on_progress: Progress = no_progress,
) -> list[GhostRow]:
    """Shares of ghosts on the road, of perturbations the strongest; from what a run has stored.

    An attack that looks different for each intention is left out: its ghosts are where the attacker
    wants them.

    Args:
        outcomes: The outcomes of a run.
        scenes: The run's scenes, whose images show road and side area.
        threshold: The least score of a detection that is planned on; others do not count.
        on_progress: Function that gets the number of scenarios that are done, and of all.

    Raises:
        DataError: A calibration, or a map, is missing or broken.
    """
    conditions = [each for each in outcomes.strongest if outcomes.looks(each) == (None,)]
    counts: dict[Condition, list[GhostCount]] = {condition: [] for condition in conditions}
    positions: dict[Condition, dict[str, list[list[float]]]] = {
        condition: {str(place): [] for place in GhostPlace} for condition in conditions
    }
    by_id = {scene.id: scene for scene in scenes.scenes.labelled}
    for number, scenario in enumerate(outcomes.scenarios):
        scene = by_id[scenario]
        view, calibration = road_view_of(scenes, scene), scenes.frame(scene).calibration
        areas = visible_areas(view, calibration)
        for condition in conditions:
            seen, truth = outcomes.detections(condition)[number], outcomes.labels[scenario]
            unreal, where = placed_ghosts(seen, truth, view, calibration, threshold=threshold)
            counts[condition].append(count_ghosts(unreal, where, areas))
            shown = positions[condition]
            if sum(map(len, shown.values())) < _SHOWN:
                for place, (x, _, z) in zip(where, unreal.location.tolist(), strict=True):
                    shown[place].append([round(x, 1), round(z, 1)])
        on_progress(number + 1, len(outcomes.scenarios))
    return [
        GhostRow(
            condition,
            ghost_summary(counts[condition], resamples=RESAMPLES),
            positions[condition],
        )
        for condition in conditions
    ]
