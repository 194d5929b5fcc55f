"""The figure is drawn of what reports and commands write, and nothing else."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest
from PIL import Image

from avsec_gym.experiments.chapter5.decoupling import decoupling
from avsec_gym.experiments.chapter5.outcomes import Condition
from avsec_gym.experiments.json_rows import as_json
from avsec_gym.metrics.estimate import Estimate
from avsec_gym.metrics.safety import SafetyRates
from studies.chapter5.decoupling_figure import main
from studies.chapter5.headroom import NOTHING, TRUTH, HeadroomRow


@pytest.mark.parametrize("detectors", [("dsgn",), ("dsgn", "stereo_rcnn")])
def test_the_figure_is_drawn_of_stored_json(
    made: ModuleType, tmp_path: Path, detectors: tuple[str, ...]
) -> None:
    results, names = made.MadeResults(), made.names(12)
    for detector in detectors:
        results.add(Condition(detector), names)
        for n in (1.0, 2.0):
            lost = names[: int(3 * n)]
            results.add(Condition(detector, "thesis_pgd-1", n), names, lost=lost, unsafe=lost[:2])
    report = {"decoupling": as_json(decoupling(made.outcomes(results, names)))}
    of_all = SafetyRates.of([made.record(name, "left") for name in names])
    headroom = [
        HeadroomRow(TRUTH, of_all, Estimate(0.0), {}),
        HeadroomRow(NOTHING, replace(of_all, collisions=3), Estimate(-25.0), {}),
    ]
    (tmp_path / "report.json").write_text(json.dumps(report))
    (tmp_path / "errors.json").write_text(json.dumps({"headroom": as_json(headroom)}))
    picture = tmp_path / "figure.png"
    files = (str(tmp_path / "report.json"), str(tmp_path / "errors.json"))
    assert main([*files, "--figure", str(picture)]) == 0
    with Image.open(picture) as drawn:
        assert drawn.width > drawn.height > 400
        assert len(drawn.convert("RGB").getcolors(1 << 20)) > 50
