"""What a run shows of the test over frames."""

from __future__ import annotations

from avsec_gym.drawing.page_table import Table, TableCell, bounds, figure, name, number
from avsec_gym.experiments.chapter4.drives.settings import OPTIONS, TOLERANCE, WINDOW
from avsec_gym.experiments.chapter4.drives.window_rates import (
    DESIGNATED_DETECTION,
    HALF,
    ONCE,
    SINGLE,
    SUMS,
    DrivesSummary,
    WindowRates,
    drives_summary,
)
from avsec_gym.experiments.chapter4.settings import ATTACKS, USUAL
from avsec_gym.experiments.json_rows import as_json
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.runs.run_folder import RunFolder
from avsec_gym.runs.section import Findings, ReportRequest, Section

GOAL = 0.001
"""Share of attack-free windows that may alarm where 95 % of decidable attacks are detected."""


def findings(run: RunFolder, request: ReportRequest) -> Findings:
    """The report's ``connected_drives``.

    Args:
        run: The run.
        request: What the report is asked for; nothing here depends on it.
    """
    summary = drives_summary(run)
    apart = {**OPTIONS, **run.configuration.options}["apart"]
    sections = [drives_section(summary, apart)] if summary else []
    return Findings(sections, {"connected_drives": as_json(summary)})


def drives_section(summary: DrivesSummary, apart: int = WINDOW) -> Section:
    """The section of a summary.

    Args:
        summary: The results of a run.
        apart: Instants from the beginning of a window to that of the next of its drive.
    """
    overlap = f" a window every {apart * 0.1:g} s, which overlap," if apart < WINDOW else ""
    return Section(
        "connected_drives",
        "What adds up over a second of successive instants?",
        drives_sentences(summary),
        [alarms_table(summary), attacks_table(summary)],
        link="Connected vehicles, over a second",
        context=f"{summary.judged} attack-free windows of {summary.drives} drives,{overlap}"
        f" by evidence of rays; limits of {summary.fitted} windows of other drives and assets."
        f" {USUAL.name}.",
    )


def drives_sentences(summary: DrivesSummary) -> list[str]:
    """False alarms and detection at the designated detection, by sums and by single instants.

    Args:
        summary: The results of a run.
    """
    rows = {(row.of, row.instants): row for row in summary.rates if row.rate is None}
    if (SUMS, ONCE) not in rows:
        return ["Of ghosts or removals on the drives that limits come from, none was decidable."]
    sentences = [_sentence(rows[SUMS, ONCE]), f"{_of_single(rows[SINGLE, ONCE])}."]
    if (SUMS, HALF) in rows:
        sentences.append(f"{_of_half(rows[SUMS, HALF])}.")
    return sentences


def _sentence(row: WindowRates) -> str:
    alarms, most = row.false_alarms, row.windows_at_most
    # By rule: the goal is met where the upper bound is, and missed where the lower bound is above.
    low = 0.0 if alarms.interval is None else alarms.interval[0]
    goal = "met" if most <= GOAL else "missed" if low > GOAL else "neither met nor missed for sure"
    found = " and ".join(
        f"{_words(row.attacks[kind].of_decidable)} of the decidable {kind}s" for kind in ATTACKS
    )
    return (
        f"Where {100 * DESIGNATED_DETECTION:g} % of the decidable attacks of other drives exceed"
        f" the limit of the sum, {_words(alarms)} of {alarms.of} attack-free windows alarm, at most"
        f" {number(most, 100, 2)} % with 97.5 % confidence (goal: {100 * GOAL:g} %, {goal}), and"
        f" {found} are detected by an alarm at their place."
    )


def _of_single(row: WindowRates) -> str:
    return (
        "By the highest score of a single instant, at the limit of the same detection,"
        f" {_words(row.false_alarms)} of the windows alarm"
    )


def _of_half(row: WindowRates) -> str:
    found = " and ".join(
        f"{_words(row.attacks[kind].of_decidable_half)} of such {kind}s" for kind in ATTACKS
    )
    return (
        "At the limit of the sum for attacks that are decidable at half of the instants or more,"
        f" {_words(row.false_alarms)} of the windows alarm, at most"
        f" {number(row.windows_at_most, 100, 2)} %, and {found} are detected"
    )


def alarms_table(summary: DrivesSummary) -> Table:
    """False alarms, by statistic and designated rate.

    Args:
        summary: The results of a run.
    """
    return Table(
        f"Attack-free windows of {WINDOW} instants that alarm",
        [
            *("evidence", "limit by", "limit", "false alarms, %"),
            *("windows, at most, %", "drives, at most, %"),
        ],
        [
            [
                *_heads(row),
                figure(row.limit, digits=1),
                _percent(row.false_alarms),
                figure(row.windows_at_most, scale=100, digits=2),
                figure(row.drives_at_most, scale=100, digits=2),
            ]
            for row in summary.rates
        ],
        "Sums add up along the track of a region, a score counting for 5 nats at most and those"
        f" after the first for less, since successive ones correlate by {summary.correlation:.2f};"
        " or, as if independent, for as much."
        " Limits are those that a share r of attack-free windows of other drives exceeds, or that"
        f" {100 * DESIGNATED_DETECTION:g} % of the decidable ghosts and as many removals of other"
        " drives exceed; below 0, all windows alarm. In brackets: 95 % intervals, which know that"
        " windows of one drive are alike. At most: the upper end of that interval, and an upper"
        " bound with 95 % confidence of the drives that alarm.",
        names=2,
    )


def attacks_table(summary: DrivesSummary) -> Table:
    """What becomes of attacks that last for the window, by kind, statistic and rate.

    Args:
        summary: The results of a run.
    """
    begun = " and ".join(f"{summary.begun[kind]} {kind}s" for kind in ATTACKS)
    return Table(
        f"Attacks that last for {WINDOW} instants",
        [
            *("attack", "evidence", "limit by", "detected, %"),
            *("covered, %", "decidable, %", "of decidable, %"),
            *("decidable at half, %", "of these, %"),
        ],
        [
            [
                name(kind),
                *_heads(row),
                _percent(row.attacks[kind].detected),
                _percent(row.attacks[kind].covered),
                _percent(row.attacks[kind].decidable),
                _percent(row.attacks[kind].of_decidable),
                _percent(row.attacks[kind].decidable_half),
                _percent(row.attacks[kind].of_decidable_half),
            ]
            for kind in ATTACKS
            for row in summary.rates
        ],
        "A ghost drives ahead of its victim, and a removed object stays away. Detected: a track"
        f" alarms while its region has its centre in the object's box, grown by {TOLERANCE:g} m."
        f" Of {begun} that began, those are left out that ended early: the victim drove into the"
        " ghost, or had no more points on the object. Decidable: enough rays of another vehicle"
        " at the victim's claim of the ghost, or of the victim at another's claim of the object, at"
        " some instant, or at half of them.",
        names=3,
    )


def _heads(row: WindowRates) -> list[TableCell]:
    if row.rate is not None:
        return [name(row.of), name(f"r = {100 * row.rate:g} %")]
    often = "once" if row.instants == ONCE else "at half"
    return [name(row.of), name(f"detection {100 * DESIGNATED_DETECTION:g} %, decidable {often}")]


def _words(share: Share) -> str:
    return f"{number(share.rate, 100)} % {bounds(share.interval, 100)}".strip()


def _percent(share: Share) -> TableCell:
    return figure(share.rate, share.interval, scale=100)
