"""Where the ghosts of a run are: on the road or beside it, held against chance (thesis, 5.5.1)."""

from __future__ import annotations

from collections.abc import Callable

from avsec_gym.experiments.chapter5.ghost_positions import (
    GhostCount,
    Place,
    count_ghosts,
    ghost_summary,
    placed_ghosts,
    visible_areas,
)
from avsec_gym.experiments.chapter5.outcomes import RESAMPLES, Condition, Outcomes
from avsec_gym.experiments.chapter5.scenes import road_view_of
from avsec_gym.experiments.chapter5.tables import Row, named
from avsec_gym.scenario.frame_scenes import FrameScenes

_SHOWN = 1000
"""Ghosts of each condition whose positions are given."""


def ghost_rows(
    outcomes: Outcomes,
    scenes: FrameScenes,
    threshold: float,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[Row]:
    """Shares of ghosts on the road, of perturbations the strongest; from what a run has stored.

    An attack that looks different for each intention is left out: its ghosts are where the attacker
    wants them.  ``positions`` are metres to the right and ahead of the camera, by `Place`, of the
    first ghosts.

    Args:
        outcomes: Of a run.
        scenes: Its scenes, whose images tell road and side area.
        threshold: Less sure detections are not planned on, and not counted.
        on_progress: Told how many scenarios of how many are looked at.

    Raises:
        DataError: A calibration, or a map, is missing or broken.
    """
    conditions = [one for one in outcomes.strongest if outcomes.looks(one) == (None,)]
    counts: dict[Condition, list[GhostCount]] = {one: [] for one in conditions}
    positions: dict[Condition, dict[str, list[list[float]]]] = {
        one: {str(place): [] for place in Place} for one in conditions
    }
    by_id = {scene.id: scene for scene in scenes.scenes.labelled}
    for number, scenario in enumerate(outcomes.scenarios):
        scene = by_id[scenario]
        view, calibration = road_view_of(scenes, scene), scenes.frame(scene).calibration
        areas = visible_areas(view, calibration)
        for one in conditions:
            seen, truth = outcomes.detections(one)[number], outcomes.labels[scenario]
            unreal, where = placed_ghosts(seen, truth, view, calibration, threshold=threshold)
            counts[one].append(count_ghosts(unreal, where, areas))
            if sum(map(len, positions[one].values())) < _SHOWN:
                for place, (x, _, z) in zip(where, unreal.location.tolist(), strict=True):
                    positions[one][place].append([round(x, 1), round(z, 1)])
        on_progress(number + 1, len(outcomes.scenarios))
    return [
        {
            **named(one),
            **ghost_summary(counts[one], resamples=RESAMPLES),
            "positions": positions[one],
        }
        for one in conditions
    ]
