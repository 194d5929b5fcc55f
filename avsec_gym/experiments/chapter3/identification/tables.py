"""The thesis' tables of chapter 3 with our figures, the thesis' beside them."""

from __future__ import annotations

from collections.abc import Sequence

from avsec_gym.drawing.page_table import Table, TableCell, figure, name, number
from avsec_gym.experiments.chapter3.attacks import OTHER, SMALLER
from avsec_gym.experiments.chapter3.identification.adaptive_attacks import (
    AGREED_DEPTH,
    AGREEING,
    DIM,
    FAR,
    OUT_OF_SIGHT,
    REMOVED,
    VEIL,
)
from avsec_gym.experiments.chapter3.identification.adaptive_rates import AdaptiveAttackRates
from avsec_gym.experiments.chapter3.identification.beyond_rates import BeyondRow
from avsec_gym.experiments.chapter3.identification.calibration import LikelihoodCalibration
from avsec_gym.experiments.chapter3.identification.detection_rates import (
    CaseRates,
    DetectionRateRow,
)
from avsec_gym.experiments.chapter3.identification.identification_rates import (
    IdentificationRates,
    MethodRates,
)
from avsec_gym.experiments.chapter3.identification.summary import Unseen, ValidationSummary
from avsec_gym.experiments.chapter3.settings import RATES, SCENARIOS
from avsec_gym.experiments.chapter3.thesis import DETECTION, ERROR_BOUNDS, IDENTIFICATION
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.validation.evidence.brightness import MIN_LIGHT
from avsec_gym.validation.state_posterior import PRIOR_ATTACKED, PRIOR_BEYOND

METHODS = {
    "algorithm 2, error": "algorithm 2, E alone (the thesis’)",
    "algorithm 2, any": "algorithm 2, all four shares",
    "maximum likelihood": "maximum likelihood",
}
"""Names of the ways to identify."""
_INDEPENDENT = "maximum likelihood, independent"
PRIOR = (
    "By the prior of maximum likelihood each sensor is attacked with a probability of"
    f" {PRIOR_ATTACKED:g}, independently, but sets beyond n − 2 are {1 / PRIOR_BEYOND:g} times"
    " rarer than that."
)
REPORTED = (
    "Reported: by the validator as it comes, which reports an open status rather than name a sensor"
    " of which it is not certain, or where no two sensors agree."
)
CRITERIA = {
    "any": "all four shares",
    "error": "E alone (the thesis’)",
    "hole_share": "holes alone",
    "densest": "disproved points of the scan alone",
    "brightness": "brightness alone",
}
"""Names of the ways to detect."""
INTERVALS = (
    "In brackets: 95 % intervals, Wilson’s, widened by what the cases of one drive have in common."
)
"""The note on intervals of shares."""
BEYOND_IN_WORDS = {
    (SMALLER, True): "a bogus return 1 m wide",
    (SMALLER, False): "a facula of 60 to 120 px",
    (OTHER, True): "a bogus return that hides what is behind it",
    (OTHER, False): "a facula half as bright",
}
"""Names of the attacks beyond the thesis' settings, on the LiDAR and on a camera."""


_ADAPTIVE = {
    DIM: f"a facula of {MIN_LIGHT - 1} grey levels",
    VEIL: "the same light everywhere",
    AGREEING: f"faculae that agree on a surface {AGREED_DEPTH:g} m ahead",
    FAR: "a bogus return 20 to 30 m ahead",
    REMOVED: "returns taken away, none added",
    OUT_OF_SIGHT: "a bogus return beside the images",
}
"""Names of the adaptive attacks."""


def tables_of_validation(summary: ValidationSummary) -> list[Table]:
    """Tables 3.1 and 3.2, attacks beyond theirs, and the calibration of the likelihood.

    Args:
        summary: The results of a run.
    """
    adaptive = summary.adaptive_attacks
    return [
        _detection_table(summary.detection),
        _case_table(summary.detection),
        _bounds_table(summary),
        _identification_table(summary.identification, summary.independent),
        *([unseen_table(summary.unseen)] if summary.unseen else []),
        _beyond_table(summary.beyond),
        *([_adaptive_table(adaptive)] if adaptive else []),
        _calibration_table(summary.calibration),
    ]


def _detection_table(rows: Sequence[DetectionRateRow]) -> Table:
    lines = []
    shown = [row for row in rows if row.rate in RATES and row.criterion in ("any", "error")]
    for row in sorted(shown, key=lambda row: (row.scenario, row.criterion, row.rate)):
        own = DETECTION.get((row.scenario, row.rate)) if row.criterion == "error" else None
        lines.append(
            [
                name(row.scenario),
                name(CRITERIA[row.criterion]),
                figure(row.rate, scale=100, digits=0),
                figure(row.rates.average, row.rates.interval, own, scale=100, digits=2),
                share_cell(row.rates.false_alarms),
            ]
        )
    return Table(
        "Table 3.1: detection rate, mean over the seven attack cases",
        ["sensors", "what counts", "r, %", "detected, %", "false alarms, %"],
        lines,
        "r: the designated false alarm rate, the share of the clean frames that thresholds were"
        " fitted on which lies beyond them; false alarms: the rate on clean frames that"
        f" nothing was fitted on. {INTERVALS} In italics: the thesis.",
        names=2,
    )


def _case_table(rows: Sequence[DetectionRateRow]) -> Table:
    order = list(CRITERIA)
    chosen = sorted(
        (row for row in rows if row.rate == 0.01),
        key=lambda row: (row.scenario, order.index(row.criterion)),
    )
    cases = [list(row.rates.cases) for row in chosen]
    lines = [
        [
            name(row.scenario),
            name(CRITERIA[row.criterion]),
            *(figure(row.rates.cases[case], scale=100) for case in names),
            share_cell(row.rates.false_alarms),
        ]
        for row, names in zip(chosen, cases, strict=True)
    ]
    positions = [_position(case, cases[0]) for case in cases[0]] if cases else []
    return Table(
        "Figures 3.6 and 3.8 at r = 1 %: detection rate in each attack case, %",
        ["sensors", "what counts", *positions, "false alarms, %"],
        lines,
        "First, second and third: the LiDAR or the rightmost camera, and the cameras left of it.",
        names=2,
    )


def _position(case: str, cases: list[str]) -> str:
    single = [case for case in cases if "+" not in case]
    words = dict(zip(single, ("first", "second", "third"), strict=True))
    return " and ".join(words[sensor] for sensor in case.split("+"))


def _bounds_table(summary: ValidationSummary) -> Table:
    """Where E lies, beside where the thesis finds it."""
    cases = ("clean", "attacked, all seven cases")
    alone = ("none of the three attacked", "one of them attacked alone")
    rows = [
        (row.scenario, SCENARIOS[row.scenario], cases, row.beside)
        for row in summary.case_distributions
    ]
    for own in summary.reference_distributions:
        if own.beside is not None:
            i, j, k = own.triple
            rows.append((error_name(own.triple), (i, j, k), alone, own.beside))
    lines = []
    for words, triple, (clean, attacked), beside in rows:
        bounds = ERROR_BOUNDS[triple]
        below = f"{clean}: below {100 * bounds.clean_below:g} %"
        above = f"{attacked}: above {100 * bounds.attacked_above:g} %"
        lines += [
            [name(words), name(below), share_cell(beside.clean_below), name(bounds.clean)],
            [name(words), name(above), share_cell(beside.attacked_above), name(bounds.attacked)],
        ]
    return Table(
        "Figures 3.5, 3.7 and 3.9: on which side of the thesis’ bounds E lies",
        ["E of", "frames", "so many, %", "the thesis"],
        lines,
        INTERVALS,
        names=2,
    )


def _identification_table(
    rows: Sequence[MethodRates], independent: Sequence[IdentificationRates]
) -> Table:
    lines = []
    for row in [*rows, *(MethodRates(_INDEPENDENT, rates) for rates in independent)]:
        rates = row.rates
        if rates.rate not in RATES:
            continue
        of_thesis = row.method == "algorithm 2, error"
        own = IDENTIFICATION[rates.rate] if of_thesis else (None,) * 5
        sensors = [
            figure(share.rate, thesis=thesis, scale=100)
            for share, thesis in zip(rates.sensors.values(), own[:4], strict=True)
        ]
        lines.append(
            [
                name(METHODS.get(row.method, row.method)),
                figure(rates.rate, scale=100, digits=0),
                *sensors,
                figure(rates.average, rates.interval, own[4], scale=100, digits=2),
                *map(share_cell, (rates.reported, rates.false_alarms, rates.beyond)),
            ]
        )
    return Table(
        "Table 3.2: identification rate of one LiDAR (S0) and three cameras",
        [
            *("method", "r, %", "S0", "S1", "S2", "S3", "mean, %"),
            *("mean reported, %", "false alarms, %", "beyond n − 2, %"),
        ],
        lines,
        "Identified: exactly the attacked sensors were named. Mean: over attacks on one sensor, up"
        f" to n − 2. {REPORTED} Beyond n − 2: exactly named among two to four attacked sensors,"
        " where the thesis promises nothing, by the most probable state, however sure; what is"
        " reported with certainty is a table of its own. False alarms: of clean frames, whichever"
        f" sensor is named. {PRIOR} Independent: they are not."
        f" {INTERVALS}",
    )


def unseen_table(unseen: Unseen) -> Table:
    """Both rates without the frames that were looked at while the method was made."""
    rows: dict[str, CaseRates | IdentificationRates] = {
        f"detected by {row.scenario}": row.rates for row in unseen.detection
    }
    rows |= {f"named by {METHODS[row.method]}": row.rates for row in unseen.identification}
    return Table(
        f"The same of the {unseen.frames:,} frames that were not looked at, r = 1 %",
        ["method", "attacks, %", "false alarms, %"],
        [
            [
                name(text),
                figure(rates.average, rates.interval, scale=100, digits=2),
                share_cell(rates.false_alarms),
            ]
            for text, rates in rows.items()
        ],
        f"The first {unseen.looked_at:,} judged frames were looked at while the method was made:"
        f" clean ones that looked attacked, attacks that were missed. {INTERVALS}",
    )


def _beyond_table(rows: Sequence[BeyondRow]) -> Table:
    lines = []
    for row in rows:
        attack = BEYOND_IN_WORDS[row.kind, row.sensor == 0]
        shares = (row.detected_by_error, row.detected, row.named, row.named_likeliest)
        lines.append([name(attack), name(f"S{row.sensor}"), *map(share_cell, shares)])
    return Table(
        "Attacks beyond the thesis’ settings, r = 1 %",
        [
            *("attack", "on", "detected by E, %", "by all four shares, %"),
            *("named by algorithm 2, %", "by maximum likelihood, %"),
        ],
        lines,
        "Else as in the thesis. Nothing was fitted on such attacks. Detected: by the LiDAR and two"
        " cameras, of S1 by three cameras; named: by all four sensors, and no other one, by all"
        f" four shares. {INTERVALS}",
        names=2,
    )


def _adaptive_table(rows: Sequence[AdaptiveAttackRates]) -> Table:
    lines = []
    for row in rows:
        detected = (row.detected.get(scenario) for scenario in SCENARIOS)
        lines.append(
            [
                name(_ADAPTIVE[row.kind]),
                name(", ".join(f"S{sensor}" for sensor in row.attacked)),
                *(share_cell(share) if share else figure(None) for share in detected),
                *map(share_cell, (row.named, row.named_likeliest, row.accused)),
            ]
        )
    return Table(
        "Adaptive attacks, r = 1 %",
        [
            *("attack", "on", *(f"detected by {scenario}, %" for scenario in SCENARIOS)),
            *("named by algorithm 2, %", "by maximum likelihood, %", "a sound one accused, %"),
        ],
        lines,
        "The attacker knows the method. Else as in the thesis. Named: exactly the attacked ones;"
        f" accused: maximum likelihood names a sensor that is not attacked. {INTERVALS}",
        names=2,
    )


def _calibration_table(calibration: LikelihoodCalibration) -> Table:
    lines = [
        [
            name(count),
            *map(share_cell, (row.right, row.wrong, row.cannot_tell, row.all_right, row.alarms)),
        ]
        for count, row in calibration.statuses.items()
    ]
    usual, alike = calibration.probabilities, calibration.all_alike
    return Table(
        "Status that maximum likelihood reports of each sensor",
        [
            "attacked sensors",
            "right, %",
            "wrong, %",
            "cannot tell, %",
            "all four right, %",
            "alarms, %",
        ],
        lines,
        f"As it comes: r = {100 * calibration.rate:g} %, certainty"
        f" {100 * calibration.certainty:g} %."
        " Statuses of all four sensors, attacked ones and sound ones, in every state of so many"
        " attacked; all four right, and alarms: of frames. Brier score of P(attacked), with states"
        f" as often as the prior expects them: {number(usual.brier, digits=4)}; always one"
        " half would be 0.25. The predicted probability and the observed share differ by"
        f" {number(100 * usual.calibration_error, digits=2)} % on average; with all states"
        " equally probable, most of them beyond n − 2, by"
        f" {number(100 * alike.calibration_error, digits=2)} % (Brier score"
        f" {number(alike.brier, digits=4)}). {PRIOR}"
        f" {INTERVALS}",
    )


def error_name(triple: Sequence[int]) -> str:
    """``E013``."""
    return "E" + "".join(map(str, triple))


def share_cell(share: Share) -> TableCell:
    """A share in percent, with its interval."""
    return figure(share.rate, share.interval, scale=100, digits=2)
