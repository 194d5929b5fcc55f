"""Marks stand where their figures say."""

from __future__ import annotations

import re

import pytest

from avsec_gym.experiments.chapter5.losses import LossRow
from avsec_gym.experiments.chapter5.outcomes import Condition
from avsec_gym.experiments.chapter5.section.plots_losses import draw_losses, legend, thesis_losses
from avsec_gym.experiments.chapter5.section.plots_steps import draw_precision
from avsec_gym.experiments.chapter5.tables import PrecisionRow
from avsec_gym.metrics.estimate import Estimate


def attack(detector: str, name: str, x: float, y: float, strength: float = 0.0) -> LossRow:
    lost = (Estimate(x, [x - 2, x + 2]), Estimate(y))
    return LossRow(Condition(detector, name, strength), *lost)


def marks(drawing: str) -> dict[str, tuple[float, float]]:
    """Pixels by hint."""
    pattern = r'data-hint="([^"]+)"[^>]*><circle cx="([\d.]+)" cy="([\d.]+)"'
    return {hint: (float(x), float(y)) for hint, x, y in re.findall(pattern, drawing)}


def test_losses_are_drawn_to_scale() -> None:
    rows = [
        attack("dsgn", "thesis_pgd-1", 40, 2, 4.0), attack("dsgn", "patch-random", 4, 20),
        attack("stereo_rcnn", "patch-random", 4, 20), attack("stereo_rcnn", "texture", 9, 9),
    ]  # fmt: skip
    dsgn, rcnn = draw_losses(rows)
    ours = {hint.partition(":")[0]: at for hint, at in marks(dsgn).items()}
    pgd, patch = ours["thesis PGD α 1, n 4"], ours["random patch"]
    assert pgd[0] > patch[0]
    assert pgd[1] > patch[1]
    # Both detectors have one scale; what is no attack to compare is not drawn.
    theirs = {hint.partition(":")[0]: at for hint, at in marks(rcnn).items()}
    assert theirs["random patch"] == patch
    assert "retextured side area" not in theirs
    assert {"Thesis, random patch", "Thesis, specific patch"} <= set(theirs)
    (per_point,) = {(pgd[0] - patch[0]) / 36}
    interval = re.search(r'<line x1="([\d.]+)"[^>]* x2="([\d.]+)"[^>]*of-thesis_pgd-1', dsgn)
    assert interval is not None
    assert float(interval[2]) - float(interval[1]) == pytest.approx(4 * per_point, abs=0.2)
    assert [key.words for key in legend(rows)] == ["thesis PGD α 1", "random patch"]


def test_the_thesis_takes_what_it_says() -> None:
    found = {(name, strength): point for name, strength, point in thesis_losses("stereo_rcnn")}
    precision, safety = found["patch-random", 0.0]
    assert precision == pytest.approx(38.20 - 37.07)
    assert safety == pytest.approx((87.0 + 95.3 + 82.1 - 68.9 - 80.1 - 65.9) / 3)
    assert set(found) == {("patch-random", 0.0), ("patch-specific", 0.0)}
    assert ("thesis_pgd-0.4", 1.0) in {loss[:2] for loss in thesis_losses("dsgn")}


def test_lines_begin_with_the_unattacked_detector() -> None:
    def row(name: str, strength: float, value: float) -> PrecisionRow:
        ours = {"ap11": [value] * 3, "ap11_interval": [[value - 1, value + 1]] * 3}
        condition = Condition("dsgn", name, strength)
        return PrecisionRow(condition, None, [9] * 3, [[100.0] * 2] * 3, {"3d": ours}, {}, None)

    rows = [row("unattacked", 0, 60), row("thesis_pgd-1", 1, 30), row("thesis_pgd-1", 2, 0)]
    (drawing,) = draw_precision(rows)
    easy = [at for hint, at in marks(drawing).items() if hint.startswith("easy")]
    assert [x for x, _ in easy] == sorted(x for x, _ in easy)
    first, second, third = (y for _, y in easy)
    assert third - second == pytest.approx(second - first, abs=0.2)
    assert draw_precision(rows[:1]) == []
