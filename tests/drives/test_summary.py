"""Rates, means and paired differences of rows."""

from __future__ import annotations

from typing import Any

import pytest

from avsec_gym.commands.drive_table import print_settings
from avsec_gym.drives.summary import summaries
from avsec_gym.drives.telling import by_scene, good, how_bad, outcome_in_words, telling
from avsec_gym.report.drives_page import _settings


def row(setting: str, scene: str, outcome: str, score: float, **more: Any) -> dict[str, Any]:
    at_fault = outcome == "collision"
    usual = {
        "hardest_braking": 0.0,
        "alarms": 0,
        "steps": 10,
        "intention": "left",
        "smallest_distance": 1.0,
    }
    return {
        "setting": setting, "scenario": scene, "outcome": outcome, "navsim_score": score,
        "at_fault": at_fault, "collision": at_fault, **usual, **more,
    }  # fmt: skip


ROWS = [
    row("truth", "a", "goal", 0.75, hardest_braking=4.1),
    row("blind", "a", "collision", 0.0),
    row("truth", "b", "goal", 1.0),
    row("blind", "b", "goal", 0.5),
    row("truth", "c", "stopped", 0.25, hardest_braking=4.0),
    row("blind", "c", "collision", 0.25, at_fault=False),
    row("truth", "d", "goal", 1.0, smallest_distance=0.2),
    row("blind", "d", "goal", 1.0, smallest_distance=None),
]


def test_each_setting_has_its_own() -> None:
    truth, blind = summaries(ROWS, ["truth", "blind"])
    assert [share.count for share in truth.rates.values()] == [0, 0, 3, 1, 0]
    assert [share.count for share in blind.rates.values()] == [1, 2, 2, 0, 0]
    assert truth.outcomes == {"goal": 3, "stopped": 1}
    assert blind.navsim_score.value == pytest.approx(1.75 / 4)
    low, high = blind.navsim_score.interval or (0.0, 0.0)
    assert 0.0 <= low < blind.navsim_score.value < high <= 1.0


def test_differences_are_those_of_the_same_drives() -> None:
    # The last drive of the second setting is not made yet: its partner does not count.
    truth, blind = summaries(ROWS[:-1], ["truth", "blind"])
    assert truth.differences == {}
    assert blind.differences["navsim_score"].value == pytest.approx((0.75 - 2.0) / 3)
    assert blind.differences["at_fault"].value == pytest.approx(1 / 3)


def test_alarms_have_a_column_where_there_are_any(capsys: pytest.CaptureFixture[str]) -> None:
    for alarms, shown in ((0, False), (3, True)):
        rows = [row("truth", "a", "goal", 0.5), row("watched", "a", "goal", 0.5, alarms=alarms)]
        found = summaries(rows, ("truth", "watched"))
        assert [each.rates["alarm"].count for each in found] == [0, int(shown)]
        print_settings(found, dict.fromkeys(("truth", "watched")))
        assert ("alarm raised" in capsys.readouterr().out) == shown
        assert ("alarm raised, %" in _settings(found).columns) == shown


def test_one_scene_has_no_interval() -> None:
    (summary,) = summaries([row("truth", "a", "goal", 1.0)] * 3, ["truth"])
    assert summary.navsim_score.interval is None


def test_drives_of_one_scene_count_less() -> None:
    several = [row("truth", f"s{i // 3}", "goal" if i < 9 else "time", 1.0) for i in range(18)]
    apart = [{**each, "scenario": str(i)} for i, each in enumerate(several)]
    widths = []
    for rows in (several, apart):
        (summary,) = summaries(rows, ["truth"])
        low, high = summary.rates["goal"].interval or (0.0, 0.0)
        widths.append(high - low)
    assert widths[0] > 1.3 * widths[1]


def test_the_greatest_contrast_is_shown_first() -> None:
    scenes = by_scene(ROWS)
    assert [scene.scenario for scene in telling(scenes)] == ["a", "c"]
    assert [scene.scenario for scene in good(scenes)] == ["d", "b"]
    assert outcome_in_words(ROWS[5]) == "collision, not at fault"
    assert how_bad(ROWS[1]) > how_bad(ROWS[5]) > how_bad(ROWS[4]) > how_bad(ROWS[0]) == 0
