"""The rule of conclusions, on values that are made up."""

from __future__ import annotations

import pytest

from avsec_gym.metrics.estimate import Estimate
from studies.reproduce.conclusions import ClaimDecision, Decided, conclusion, decision
from studies.reproduce.rows import Claim, DataKind

CONFIRMED, CONTRADICTED = ClaimDecision.CONFIRMED, ClaimDecision.CONTRADICTED


@pytest.mark.parametrize(
    ("claim", "interval", "expected"),
    [
        # The thesis' value is 0.9; intervals below it, around it, above it.
        (Claim.IS, (0.7, 0.8), CONTRADICTED),
        (Claim.IS, (0.85, 0.92), CONFIRMED),
        (Claim.IS, (0.9, 0.92), CONFIRMED),
        (Claim.IS, (0.95, 0.99), CONTRADICTED),
        (Claim.IS, (0.6, 0.99), ClaimDecision.TOO_WIDE),
        (Claim.AT_LEAST, (0.7, 0.8), CONTRADICTED),
        (Claim.AT_LEAST, (0.85, 0.92), CONFIRMED),
        (Claim.AT_LEAST, (0.6, 0.99), ClaimDecision.TOO_WIDE),
        (Claim.AT_LEAST, (0.91, 0.99), CONFIRMED),
        (Claim.AT_LEAST, (0.0, 0.89), CONTRADICTED),  # Wide, but all of it is on one side.
        (Claim.AT_MOST, (0.7, 0.8), CONFIRMED),
        (Claim.AT_MOST, (0.91, 0.99), CONTRADICTED),
        (Claim.IS, None, ClaimDecision.NO_INTERVAL),
    ],
)
def test_what_an_estimate_decides(
    claim: Claim, interval: tuple[float, float] | None, expected: ClaimDecision
) -> None:
    assert decision(claim, 0.9, Estimate(0.8, interval), widest=0.1) is expected


def test_what_is_not_there_or_too_little_decides_nothing() -> None:
    sure = Estimate(0.9, (0.89, 0.91))
    assert decision(Claim.IS, 0.9, None, 0.1) is ClaimDecision.NOT_MEASURED
    assert decision(Claim.IS, 0.9, Estimate(None), 0.1) is ClaimDecision.NOT_MEASURED
    assert decision(Claim.IS, 0.9, sure, 0.1, clusters=4) is ClaimDecision.TOO_FEW
    assert decision(Claim.IS, 0.9, sure, 0.1, clusters=5) is CONFIRMED


def made(
    decided: ClaimDecision, kind: DataKind = DataKind.TWIN, where: str = "", state: str = "current"
) -> Decided:
    return Decided(decided, kind, f"experiment of {where}" if where else "patch", where, state)


@pytest.mark.parametrize(
    ("decided", "expected"),
    [
        ([made(CONFIRMED)], "confirmed (twin)"),
        ([made(CONFIRMED, where="a"), made(CONFIRMED, where="b")], "confirmed (twin)"),
        ([made(CONTRADICTED)], "contradicted by `patch` (twin)"),
        ([made(CONTRADICTED, state="stale")], "contradicted by `patch` (twin, stale)"),
        (
            [made(CONFIRMED, where="a"), made(CONTRADICTED, where="b"), made(CONFIRMED, where="c")],
            "confirmed where a, c; contradicted where b, by `experiment of b` (twin)",
        ),
        # The weightier kind decides alone, whatever the order, if it decides anything.
        ([made(CONTRADICTED), made(CONFIRMED, DataKind.REAL)], "confirmed (real)"),
        (
            [made(CONTRADICTED, DataKind.PROCEDURAL), made(ClaimDecision.TOO_FEW, DataKind.REAL)],
            "contradicted by `patch` (procedural)",
        ),
        (
            [
                made(ClaimDecision.TOO_WIDE),
                made(ClaimDecision.TOO_WIDE),
                made(ClaimDecision.NO_INTERVAL),
            ],
            "open (the interval is too wide; no interval)",
        ),
        ([made(ClaimDecision.NOT_MEASURED, state="not made yet")], "open (not measured yet)"),
        ([], "open (not measured yet)"),
    ],
)
def test_the_conclusion_on_a_row(decided: list[Decided], expected: str) -> None:
    assert conclusion(decided) == expected
