"""Writes studies/results/driving_safety.md: the main job on the labelled scenarios of real KITTI.

python -m studies.driving_safety.report --scenarios DIR --detections DIR
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from avsec_gym.evaluation.rates import (
    DETECTIONS,
    GROUND_TRUTH,
    AnyScene,
    Detected,
    DrivingSafety,
    RatesKey,
    driving_safety,
    in_group,
    threshold_sweep,
)
from avsec_gym.experiments.json_rows import row_json, row_of
from avsec_gym.kitti.detections import DetectionFolder
from avsec_gym.planners.plan import Plan
from avsec_gym.planners.planner import Algorithm, Mode, MotionPrimitivePlanner
from avsec_gym.planners.primitives import MotionPrimitives, generate_primitives
from avsec_gym.road_type import RoadType
from avsec_gym.scenario.intention import Intention
from avsec_gym.scenario.planning_scenario import PlanningScenario
from avsec_gym.scenario.scene import Motion
from avsec_gym.scenario.scene_set import SceneSet
from avsec_gym.scenario.scene_sets import WITHOUT_CARS, labelled_scenarios
from studies.driving_safety.page import page
from studies.driving_safety.rows import (
    DifferenceRow,
    DrivingSafetyResults,
    FlipsRow,
    RatesRow,
    SeedRow,
    SweepRow,
    VariantRow,
)

BOTH = tuple(Algorithm)
SEEDS = range(5)
_NODE_LIMIT = 20_000


def main(arguments: Sequence[str] | None = None) -> None:
    """Run all variants, write the page and its JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenarios", type=Path, required=True)
    parser.add_argument("--detections", type=Path, required=True)
    parser.add_argument("--out", type=Path, default=Path("studies/results"))
    options = parser.parse_args(arguments)
    results = run(options.scenarios, options.detections)
    options.out.mkdir(parents=True, exist_ok=True)
    text = json.dumps(row_json(results), indent=1, allow_nan=False)
    (options.out / "driving_safety.json").write_text(text + "\n")
    (options.out / "driving_safety.md").write_text(page(results))


def run(scenarios: Path, detections: Path) -> DrivingSafetyResults:
    """All variants; what `page` shows."""
    scenes = labelled_scenarios(scenarios)
    boxes, missing = DetectionFolder(detections).read([scene.id for scene in scenes.scenes])
    detected = Detected(boxes, missing=tuple(missing))
    main_job = driving_safety(scenes, planners=BOTH, detected=detected)
    unaware = driving_safety(scenes, planners=BOTH, truth_motion=Motion.STATIC)
    aware = driving_safety(scenes, detected=detected, detected_motion=Motion.TRUTH)
    drawn = tuple(replace(scene, draw_start_speed=True) for scene in scenes.labelled)
    start_speeds = driving_safety(replace(scenes, scenes=drawn), planners=BOTH)
    thresholds = np.quantile(detected.all_scores, [0.0, 0.2, 0.4, 0.6, 0.8])
    return DrivingSafetyResults(
        scenarios=len(scenes),
        detector=detections.name,
        score_threshold=detected.score_threshold,
        ground_truth=_rows(main_job, GROUND_TRUTH),
        without_scenes_without_cars=_rows(
            main_job, GROUND_TRUTH, lambda scene: scene.group != WITHOUT_CARS
        ),
        groups={
            group: _rows(main_job, GROUND_TRUTH, in_group(group))
            for group in sorted({scene.group for scene in scenes.scenes})
        },
        motion_unknown=_rows(unaware, GROUND_TRUTH),
        drawn_start_speeds=_rows(start_speeds, GROUND_TRUTH),
        speeds_of_others=_over_seeds(scenarios),
        other_planners=_with_other_planners(scenes),
        detections=_rows(main_job, DETECTIONS),
        detections_without_scenes_without_cars=_rows(
            main_job, DETECTIONS, lambda scene: scene.group != WITHOUT_CARS
        ),
        differences=[row_of(DifferenceRow, row.to_json()) for row in main_job.differences()],
        detections_motion_known=_rows(aware, DETECTIONS),
        flips=_flips(main_job),
        sweep=[row_of(SweepRow, row) for row in threshold_sweep(scenes, detected, thresholds)],
        remarks=scenes.remarks,
    )


def _rows(
    result: DrivingSafety, name: str, keep: Callable[[AnyScene], bool] = lambda scene: True
) -> list[RatesRow]:
    return [
        RatesRow(Algorithm(cell.planner), Intention(cell.intention), result.rates(cell, keep))
        for cell in result.records
        if cell.input == name
    ]


def _over_seeds(scenarios: Path) -> list[SeedRow]:
    """The same with other draws of the moving objects' speeds."""
    rows = []
    for seed in SEEDS:
        result = driving_safety(
            labelled_scenarios(scenarios, seed=seed), truth_motion=Motion.STATIC
        )
        rows += [SeedRow(seed, row) for row in _rows(result, GROUND_TRUTH)]
    return rows


def _with_other_planners(scenes: SceneSet) -> list[VariantRow]:
    """Step by step from this planner to commonroad-search with the smaller set of primitives."""
    speeds = {RoadType.STREET: (6.0,), RoadType.HIGHWAY: (11.0, 13.0)}
    fewer = {road_type: generate_primitives(own) for road_type, own in speeds.items()}
    rows = []
    for name, planner_of in (
        ("this project's", None),
        (
            "6 m/s alone on streets",
            lambda a: _ByRoadType(fewer, MotionPrimitivePlanner(Algorithm(a))),
        ),
        (
            "and commonroad-search's search",
            lambda a: _ByRoadType(
                fewer, MotionPrimitivePlanner(Algorithm(a), Mode.REFERENCE, node_limit=_NODE_LIMIT)
            ),
        ),
    ):
        result = driving_safety(scenes, planner_of=planner_of)
        rows += [VariantRow(name, row) for row in _rows(result, GROUND_TRUTH)]
    return rows


@dataclass(frozen=True)
class _ByRoadType:
    """A planner with primitives of its own for each road type."""

    primitives: Mapping[RoadType, MotionPrimitives]
    planner: MotionPrimitivePlanner

    def plan(self, scenario: PlanningScenario) -> Plan:
        assert scenario.road_type is not None
        return replace(self.planner, primitives=self.primitives[scenario.road_type]).plan(scenario)


def _flips(result: DrivingSafety) -> list[FlipsRow]:
    return [
        FlipsRow(
            intention=str(intention),
            became_unsafe=len(flips),
            collisions=sum(after.collision for _, _, after in flips),
            no_plan=sum(not after.planned for _, _, after in flips),
        )
        for intention in Intention
        for flips in [result.flips(str(Algorithm.ASTAR), str(intention))]
        if RatesKey(str(Algorithm.ASTAR), str(intention), DETECTIONS) in result.records
    ]


if __name__ == "__main__":
    main()
