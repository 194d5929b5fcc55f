"""The picture of the documentation, of the report that is shipped."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from avsec_gym.drawing.scenario_picture import picture_array
from avsec_gym.experiments.chapter3.identification.summary import ValidationSummary
from avsec_gym.experiments.json_rows import row_of
from studies.chapter3.identification_figure import draw_identification, main

REPORT = Path(__file__).parents[3] / "studies" / "results" / "identification_sgbm.json"


def test_it_shows_what_the_report_says(tmp_path: Path) -> None:
    assert main([str(REPORT), "--out", str(tmp_path / "figure.png")]) == 0
    assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")
    summary = row_of(ValidationSummary, json.loads(REPORT.read_text())["validation"])
    figure = draw_identification(summary)
    named = figure.axes[4]
    (likeliest, algorithm_2, by_error, thesis) = named.lines
    rows = {(row.method, row.rates.rate): row.rates for row in summary.identification}
    for line, method in (
        (likeliest, "maximum likelihood"),
        (algorithm_2, "algorithm 2, any"),
        (by_error, "algorithm 2, error"),
    ):
        shown = dict(zip(line.get_xdata(), line.get_ydata(), strict=True))
        assert shown[0.01] == rows[method, 0.01].average
    assert dict(zip(thesis.get_xdata(), thesis.get_ydata(), strict=True))[0.01] == 0.9815
    drawn = picture_array(figure).astype(int)
    red, green, blue = drawn[..., 0], drawn[..., 1], drawn[..., 2]
    assert ((red > green + 80) & (red > blue + 80)).sum() > 500


@pytest.mark.parametrize("content", ["{}", "no JSON", '{"validation": null}', "[]"])
def test_another_file_is_an_error(
    tmp_path: Path, content: str, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "report.json"
    path.write_text(content)
    assert main([str(path), "--out", str(tmp_path / "figure.png")]) == 1
    assert "avsec report RUN --json" in caplog.text
    assert not (tmp_path / "figure.png").exists()
