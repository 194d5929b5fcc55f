"""Rows are flat in JSON, and their keys are those that programs read."""

from __future__ import annotations

import json
from dataclasses import replace
from types import ModuleType

import pytest

from avsec_gym.experiments.chapter5.figures import ChapterFigures
from avsec_gym.experiments.chapter5.ghost_positions import GhostCount, ghost_summary
from avsec_gym.experiments.chapter5.ghost_shares import GhostRow
from avsec_gym.experiments.chapter5.outcomes import Condition
from avsec_gym.experiments.chapter5.pyramid import PyramidRow
from avsec_gym.experiments.chapter5.seen import SeenRow
from avsec_gym.experiments.chapter5.tables import precision_rows
from avsec_gym.experiments.json_rows import as_json, row_json, row_of
from avsec_gym.metrics.estimate import NOTHING, Estimate
from avsec_gym.metrics.paired import paired_differences

CONDITION = Condition("dsgn", "thesis_pgd-1", 4.0)


def test_a_row_is_flat_and_intervals_stand_beside_their_figures() -> None:
    assert row_json(SeenRow(CONDITION, Estimate(0.5, (0.25, 0.75)), NOTHING, Estimate(1.0))) == {
        "detector": "dsgn", "attack": "thesis_pgd-1", "strength": 4.0, "whole_levels": False,
        "cars_found": 0.5, "cars_found_interval": [0.25, 0.75],
        "ghosts_in_lanes": None, "ghosts_in_lanes_interval": None,
        "ghosts_beside": 1.0, "ghosts_beside_interval": None,
    }  # fmt: skip


def test_conditions_and_estimates_are_read_back() -> None:
    row = SeenRow(CONDITION, Estimate(0.5, (0.25, 0.75)), NOTHING, Estimate(1.0))
    columns = row_json(row)
    again = row_of(SeenRow, json.loads(json.dumps(columns)))
    assert again == replace(row, cars_found=Estimate(0.5, [0.25, 0.75]))
    del columns["cars_found_interval"]
    with pytest.raises(KeyError, match="cars_found_interval"):
        row_of(SeenRow, columns)


def test_inner_rows_stand_among_the_columns() -> None:
    summary = ghost_summary([GhostCount(1, 3, 0, 0, 50.0, 50.0)] * 2, resamples=10)
    row = row_json(GhostRow(CONDITION, summary, {"road": [[1.0, 2.0]]}))
    assert (row["attack"], row["ghosts"], row["share_on_road"]) == ("thesis_pgd-1", 8, 0.25)
    assert "summary" not in row
    figures = {"safety_with": Estimate(90.0, (80, 95))}
    assert row_json(PyramidRow("unattacked", 7, figures)) == {
        "attack": "unattacked", "scenarios": 7,
        "safety_with": 90.0, "safety_with_interval": [80, 95],
    }  # fmt: skip


def test_figures_that_a_run_has_not_have_no_keys() -> None:
    assert row_json(ChapterFigures(0, [], [])) == {"scenarios": 0, "left_out": [], "planners": []}


def test_a_key_may_be_no_name_in_python(made: ModuleType) -> None:
    results, names = made.MadeResults(), made.names(3)
    results.add(Condition("dsgn"), names)
    (row,) = as_json(precision_rows(made.outcomes(results, names)))  # type: ignore[misc]
    assert set(row["precision_iou_0.5"]) == {"bev", "3d"}
    json.dumps(row, allow_nan=False)


def test_paired_rates_of_a_row_are_those_of_the_metric(made: ModuleType) -> None:
    before = [made.record(name, "left") for name in made.names(4)]
    after = [made.record(name, "left", "collision") for name in made.names(4)]
    paired = paired_differences(before, after)
    assert paired is not None
    assert as_json(paired) == paired.to_json()
