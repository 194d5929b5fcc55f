"""The figures of chapter 4, and where ours stand."""

from __future__ import annotations

from collections.abc import Iterator

from avsec_gym.experiments.chapter4.detection_rates import PAIRS
from avsec_gym.experiments.chapter4.settings import EXACT, USUAL
from avsec_gym.experiments.chapter4.thesis import DETECTION, DISTANCE_BOUND
from studies.chapter4.viewpoints import DELAUNAY, SUCCESSIVE
from studies.reproduce.rows import MOST, Claim, DataKind, Measured, ThesisRow, measured
from studies.result_fields import field, row

_CONDITIONS = {EXACT.name: "exact poses and clocks", USUAL.name: "erring poses and clocks"}
_RESULT = field("chapter4", "connected")
_VIEWPOINTS = field("connected_viewpoints", "ways").then(
    row(viewpoints=SUCCESSIVE, mesher=DELAUNAY, sides=0.0, attack="ghost")
)
_SAID = {0.1: "very close to 70 %", 0.3: "over 90 %"}


def chapter4_rows() -> list[ThesisRow]:
    """All of them, in the thesis' order."""
    return [*_distances(), *_detection()]


def _distances() -> Iterator[ThesisRow]:
    """Figure 4a."""
    for state, what, claim in (
        ("clean", "attack-free distances", Claim.AT_LEAST),
        ("ghost", "distances of a ghost", Claim.AT_MOST),
    ):
        yield ThesisRow(
            "Figure 4a",
            f"{what} below {DISTANCE_BOUND:g} m",
            MOST,
            tuple(
                measured(
                    _RESULT.then("distances", row(condition=condition), "below", state),
                    DataKind.PROCEDURAL,
                    "chapter4",
                    where,
                )
                for condition, where in _CONDITIONS.items()
            ),
            claim,
            said="the majority" if state == "clean" else "most are larger",
        )


def _detection() -> Iterator[ThesisRow]:
    """Figure 4b."""
    for rate, thesis in DETECTION.items():
        yield ThesisRow(
            "Figure 4b",
            f"ghosts detected, r = {rate:g}",
            thesis,
            tuple(_detected(rate)),
            Claim.AT_LEAST,
            said=_SAID[rate],
        )


def _detected(rate: float) -> Iterator[Measured]:
    # By the thesis' method alone: what rays detect confirms nothing about it.
    for condition, where in _CONDITIONS.items():
        columns = row(condition=condition, kind="ghost", method="surfaces", of=PAIRS, rate=rate)
        yield measured(
            _RESULT.then("detection", columns, "detected"),
            DataKind.PROCEDURAL,
            "chapter4",
            f"surfaces with {where}",
        )
    # The thesis' own data: three scans of one vehicle that passes.
    yield measured(
        _VIEWPOINTS.then("detection", row(rate=rate), "detected"),
        DataKind.PROCEDURAL,
        "connected_viewpoints",
        "surfaces with the viewpoints of one vehicle",
    )
