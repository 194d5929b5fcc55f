"""Planning anew at the run's own threshold gives the run's own episodes."""

from __future__ import annotations

from types import ModuleType, SimpleNamespace

from avsec_gym.boxes import Boxes3D
from avsec_gym.experiments.chapter5.outcomes import Condition
from avsec_gym.experiments.json_rows import row_json, row_of
from avsec_gym.scenario.scene import Motion, Scene
from studies.chapter5.score_thresholds import SweptThresholds, page, threshold_rows

CLEAN, PATCH = Condition("dsgn"), Condition("dsgn", "patch-random")
GHOST = Boxes3D([[0.0, 1.65, 9.0]], [[1.5, 3.4, 6.0]], [-1.57], [0.4], ["Car"])
"""In the lane, so near that there is no way around it."""


def test_a_ghost_blocks_the_lane_until_the_threshold_is_above_its_score(made: ModuleType) -> None:
    results, names = made.MadeResults(), ["000001", "000002"]
    results.add(CLEAN, names)
    results.add(PATCH, names, extra=GHOST)
    outcomes = made.outcomes(results, names)
    empty = [Scene(name, Boxes3D.empty(), "street") for name in names]
    scenes = SimpleNamespace(scenes=SimpleNamespace(labelled=empty))
    progress: list[tuple[int, int]] = []
    rows = threshold_rows(
        outcomes,
        scenes,  # type: ignore[arg-type]
        Motion.STATIC,
        (0.3, 0.95),
        lambda *done: progress.append(done),
    )
    safe = {(row.condition.attack, row.threshold): row.rates.safe_driving_rate for row in rows}
    assert safe["patch-random", 0.95] == safe["unattacked", 0.95] == 1.0
    assert safe["patch-random", 0.3] < safe["unattacked", 0.3]
    assert progress == [(1, 2), (2, 2)]
    swept = row_of(SweptThresholds, row_json(SweptThresholds(2, rows)))
    assert [row.condition for row in swept.rows] == [row.condition for row in rows]
    text = page(swept, "command")
    assert "random patch" in text
    assert "| 100.0 |" in text
