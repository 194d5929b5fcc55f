"""The table of drives in closed loop, and its page."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import spearmanr

from avsec_gym.cli import run
from avsec_gym.drives.summary import RATES, Mean, SettingSummary
from avsec_gym.experiments.json_rows import row_json, row_of
from avsec_gym.metrics.clustered_shares import share_of
from studies.driving_safety.closed_loop import (
    LoopSettingRates,
    LoopTable,
    LoopTables,
    Ranking,
    judged_models,
    pooled_rankings,
    ranking,
    table,
)
from studies.driving_safety.closed_loop_page import closed_loop_page
from studies.driving_safety.closed_loop_page import main as closed_loop_page_main

SETTINGS = ("a", "b", "c", "d")


def rows(unsafe: dict[str, int], collisions: dict[str, int]) -> list[Any]:
    """Twenty drives of each setting, the first ones unsafe or with a collision."""
    return [
        {
            "setting": name,
            "scenario": f"{number}",
            "first_plan": "collision" if number < unsafe[name] else "safe",
            "collision": number < collisions[name],
        }
        for name in SETTINGS
        for number in range(20)
    ]


def by_scene(row: Any) -> str:
    return str(row["scenario"])


def test_the_ranking_is_spearmans() -> None:
    unsafe = dict(zip(SETTINGS, (2, 5, 9, 14), strict=True))
    collisions = dict(zip(SETTINGS, (1, 7, 6, 12), strict=True))
    found = ranking(rows(unsafe, collisions), SETTINGS, by_scene)
    expected = spearmanr(list(unsafe.values()), list(collisions.values())).statistic
    assert found.rho == pytest.approx(expected)
    assert found.interval is not None
    assert found.rho is not None
    low, high = found.interval
    assert -1 <= low <= found.rho <= high <= 1
    assert low > 0


def test_rankings_are_pooled_over_sets_and_within_each_detector() -> None:
    names = ("dsgn", "dsgn_patch", "dsgn_thesis_pgd", "stereo_rcnn", "stereo_rcnn_patch", "truth")
    bad = dict(zip(names, (2, 4, 8, 1, 9, 0), strict=True))
    drives: list[Any] = [
        {
            "setting": name,
            "scenario": str(number),
            "first_plan": "collision" if number < bad[name] else "safe",
            "collision": number < 2 * bad[name] - (name == "dsgn_patch") * 5,
        }
        for name in names
        for number in range(20)
    ]
    every, stereo, dsgn = pooled_rankings({"labels": drives, "drives": drives})
    assert (every.of, stereo.of, dsgn.of) == ("", "stereo_rcnn", "dsgn")
    assert list(dsgn.first_plans) == ["dsgn", "dsgn_patch", "dsgn_thesis_pgd"]
    assert list(dsgn.loop) == ["dsgn_patch", "dsgn", "dsgn_thesis_pgd"]
    assert dsgn.ranking.rho == pytest.approx(0.5)
    assert stereo.ranking.rho is None, "two settings have no order worth a correlation"
    assert "truth" not in every.loop
    text = closed_loop_page(LoopTables(pooled=[every, stereo, dsgn]))
    assert "| `dsgn` | dsgn < dsgn_patch < dsgn_thesis_pgd | dsgn_patch < dsgn <" in text


def test_what_is_the_same_for_all_ranks_nothing() -> None:
    same = dict.fromkeys(SETTINGS, 3)
    assert ranking(rows(same, same), SETTINGS, by_scene).rho is None
    assert ranking(rows(same, same), SETTINGS[:1], by_scene).interval is None


def test_a_collision_at_fault_under_truth_has_its_certificates(tmp_path: Path) -> None:
    """A pedestrian crosses at 7 m/s, a metre before the bumper: no car and no plan avoids that."""
    out = tmp_path / "rendered"
    scenes = '{"source": "layouts", "count": 100}'
    words = ["--ids", "street-000024", "--scenarios", scenes, "--pictures", "0"]
    assert run(["drive", "--settings", "truth", "--out", str(out), *words]) == 0
    result = LoopTables(rendered=table(out))
    assert result.rendered is not None
    [found] = result.rendered.truth_at_fault
    assert found.unavoidable_after is not None
    assert found.no_plan_since == 0.0
    text = closed_loop_page(row_of(LoopTables, json.loads(json.dumps(row_json(result)))))
    assert "from 0 s on a complete search finds no plan without it" in text
    assert "no car could have avoided it beyond" in text
    assert "on rendered sensors" in text


@pytest.mark.parametrize(
    ("scenes", "collisions", "believed"),
    [(60, 12, True), (60, 30, False), (60, 1, False), (49, 12, False)],
)
def test_an_error_model_is_believed_within_the_rendered_interval(
    scenes: int, collisions: int, believed: bool
) -> None:
    def setting(name: str, hits: int) -> LoopSettingRates:
        share = share_of(
            [number < hits for number in range(scenes)], [str(number) for number in range(scenes)]
        )
        mean = Mean(1.0, None)
        names = ("collision", "at_fault", "goal", "hard_braking", "alarm")
        rates = dict.fromkeys(names, share)
        return LoopSettingRates(SettingSummary(name, scenes, scenes, rates, mean, {}, 0, {}), share)

    settings = [setting("dsgn", collisions), setting("rendered_dsgn", 12), setting("blind", 3)]
    driven = LoopTable(scenes, [*settings, setting("rendered_late", 0)], Ranking(None, None), [])
    (judged,) = judged_models({"models": driven})
    assert (judged.model, judged.rendered.count, judged.believed) == ("dsgn", 12, believed)
    # What drives beside other settings is rendered with those, under their names.
    modelled = LoopTable(scenes, [setting("stereo_rcnn", collisions)], Ranking(None, None), [])
    rendered = LoopTable(scenes, [setting("detector", 12)], Ranking(None, None), [])
    assert judged_models({"models": modelled}) == []
    (other,) = judged_models({"models": modelled, "rendered": rendered})
    assert (other.model, other.rendered.count, other.believed) == ("stereo_rcnn", 12, believed)
    result = LoopTables(models=driven, judged_models=[judged])
    text = closed_loop_page(row_of(LoopTables, json.loads(json.dumps(row_json(result)))))
    assert f"| `dsgn` | {scenes} |" in text
    assert f"| {'yes' if believed else 'no'} |" in text
    assert "cannot be ranked" not in text, "there is no truth to rank beside"


def test_the_parts_that_are_there_make_one_page(tmp_path: Path) -> None:
    out = tmp_path / "page.md"
    words = ["--results", str(tmp_path), "--out", str(out)]
    assert closed_loop_page_main(words) == 1, "there is none"
    share = share_of([True, False], ["a", "b"])
    summary = SettingSummary("truth", 2, 2, dict.fromkeys(RATES, share), Mean(1.0, None), {}, 0, {})
    driven = LoopTable(2, [LoopSettingRates(summary, share)], Ranking(None, None), [])
    for name, part in (
        ("closed_loop_scenes", LoopTables(labels=driven, tracking=driven)),
        ("closed_loop_rendered", LoopTables(models=driven, looked_at=70)),
    ):
        (tmp_path / f"{name}.json").write_text(json.dumps(row_json(part)))
    assert closed_loop_page_main(words) == 0
    text = out.read_text()
    titles = [line for line in text.splitlines() if line.startswith("## ")]
    assert len(titles) == 3
    assert "first of 70 procedural drives" in text
    (tmp_path / "closed_loop_rendered.json").write_text('{"labels": 3}')
    assert closed_loop_page_main(words) == 1


def test_from_drives_to_a_page(tmp_path: Path) -> None:
    out = tmp_path / "labels"
    words = ["--scenarios", "layouts", "--limit", "4", "--duration", "2", "--pictures", "0"]
    late = '{"name": "late", "perception": "blind", "planner": "gbfs"}'
    assert run(["drive", "--settings", "truth", "blind", late, "--out", str(out), *words]) == 0
    result = json.loads(json.dumps(row_json(LoopTables(labels=table(out)))))
    truth, blind, _ = result["labels"]["settings"]
    assert truth["first_plan"]["rate"] >= blind["first_plan"]["rate"]
    assert (truth["first_plan"]["of"], blind["rates"]["collision"]["of"]) == (4, 4)
    text = closed_loop_page(row_of(LoopTables, result))
    assert "`blind` | 4 |" in text
    assert not np.any([word in text for word in ("None", "nan")])
