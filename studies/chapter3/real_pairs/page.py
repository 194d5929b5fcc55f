"""What `judge` found, as a page.

Run ``python -m studies.chapter3.real_pairs.page RESULT.json --out PAGE.md``.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.report.markdown_table import UNKNOWN, markdown_table, number
from studies.chapter3.real_pairs.disc_light import MEAN_OF_PEAK
from studies.chapter3.real_pairs.result import RULES, RealPairsResult
from studies.page_of_result import page_of_result

_COMMAND = "python -m studies.chapter3.real_pairs.judge --kitti ROOT --json FILE"
_RULES = {
    "rendered": "threshold of rendered frames",
    "raised": "raised by clean real pairs",
    "discs": "mean over discs",
}


def real_pairs_page(result: RealPairsResult) -> str:
    """Markdown: false alarms of clean real pairs, and lights that are too faint.

    Args:
        result: The result of `studies.chapter3.real_pairs.judge.run`.
    """
    raised = result.raised
    alone = result.false_alarms["rendered"]
    lines = [
        "# Real pairs of images: false alarms, and small and faint lights",
        "",
        f"Made by `{_COMMAND}`, shown by its `page`. {len(result.pairs)} real pairs of"
        f" {raised.clusters} scenes, in all layouts at hand. Brightness alone is judged, which"
        f" needs no scan, at r = {100 * result.rate:g} %. Intervals are 95 %; pairs of one scene,"
        " and the draws on them, are one cluster.",
        "",
        "## Clean pairs",
        "",
        f"The threshold of rendered frames is {_measure(result.rendered)} % ({result.origin}); of"
        f" the clean real pairs {alone.count} of {alone.of} lie above it. **The rule**: the"
        " threshold is raised to the lowest value that a tolerance bound (Wilks 1941) lets stand"
        " for r with 95 % confidence, one value for each scene, its largest; with too few scenes"
        f" for any, to the largest of all. That is {_measure(raised.value)} %, above which no clean"
        f" real pair at hand lies. {raised.clusters} scenes vouch for"
        f" {_percent(raised.vouched)} % at most; r = {100 * result.rate:g} % takes"
        f" {raised.fewest}. No attacked image has a say. In the table each scene is judged by a"
        " threshold that the other scenes alone have raised, and by discs that are brighter than"
        " theirs.",
        "",
        *_clean_table(result),
        "",
        "## Where physics ends it",
        "",
        "Single pixels of clean pairs differ by the noise of two cameras and a matcher’s errors."
        " The mean over a disc differs less, but not as little as if all of it were noise: surfaces"
        " shine into one camera only. No threshold on that mean separates a light from a clean"
        " pair where it stays below the brightest clean disc of its size."
        f" A Gaussian light has {_percent(MEAN_OF_PEAK)} % of its peak as its mean over its disc.",
        "",
        *_floor_table(result),
        "",
        "## Small and faint lights",
        "",
        f"{result.draws} draws of each light in each pair, into either camera in turn; thresholds"
        " have seen no pair of the scene that they judge.",
        "",
        *_light_table(result),
        "",
        *_sentences(result),
        "",
    ]
    return "\n".join(lines)


def _clean_table(result: RealPairsResult) -> list[str]:
    rows = [
        [
            pair.id,
            _measure(pair.brightness),
            number(pair.pixel_noise, 1),
            *("a false alarm" if pair.alarms[rule] else "no alarm" for rule in RULES),
        ]
        for pair in result.pairs
    ]
    shares = [_share(result.false_alarms[rule]) for rule in RULES]
    rows.append(["false alarms, %", "", "", *shares])
    titles = ["brightness, %", "a pixel’s noise, grey levels"]
    return markdown_table(["pair", *titles, *(_RULES[rule] for rule in RULES)], rows)


def _floor_table(result: RealPairsResult) -> list[str]:
    rows = [
        [
            number(row.radius, 1),
            _percent(row.area),
            number(row.noise, 2),
            number(row.floor.value, 1),
            number(row.peak, 0),
        ]
        for row in result.floors
    ]
    return markdown_table(
        [
            "radius, px of 1242",
            "share of the image, %",
            "three deviations of the mean of noise alone, grey levels",
            "brightest clean disc, grey levels",
            "peak of a Gaussian light as bright",
        ],
        rows,
    )


def _light_table(result: RealPairsResult) -> list[str]:
    area = {row.radius: row.area for row in result.floors}
    peak = {row.radius: row.peak for row in result.floors}
    rows = [
        [
            f"{number(row.radius, 1)} ({_percent(area[row.radius])} %)",
            number(row.strength, 0) + (" (below)" if row.strength < peak[row.radius] else ""),
            *(_share(row.detected[rule]) for rule in RULES),
        ]
        for row in result.lights
    ]
    titles = [f"detected by the {_RULES['rendered']}, %"]
    titles += [f"by that {_RULES['raised']}, %", f"by the {_RULES['discs']}, %"]
    return markdown_table(["radius", "peak, grey levels", *titles], rows)


def _sentences(result: RealPairsResult) -> list[str]:
    """How far the rules are from what the data allow."""
    peak = {row.radius: row.peak for row in result.floors}
    above = [row for row in result.lights if row.strength >= peak[row.radius]]
    if not above:
        return ["No light was stronger than the brightest clean disc of its size."]
    counts = {rule: [row.detected[rule] for row in above] for rule in RULES}
    shares = {
        rule: 100 * sum(row.count for row in rows) / sum(row.of for row in rows)
        for rule, rows in counts.items()
    }
    return [
        "Of the lights that are stronger than the brightest clean disc of their size"
        f" {number(shares['raised'], 1)} % are detected by the raised threshold and"
        f" {number(shares['discs'], 1)} % by the mean over discs of any of these sizes."
        " “Below”: weaker than it."
    ]


def _measure(value: float) -> str:
    return number(100 * value, 3)


def _percent(value: float) -> str:
    return number(100 * value, 1)


def _share(share: Share) -> str:
    if share.rate is None or share.interval is None:
        return UNKNOWN
    low, high = (number(100 * bound, 1) for bound in share.interval)
    return f"{number(share.percent, 1)} [{low}, {high}]"


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    return page_of_result(
        arguments,
        RealPairsResult,
        real_pairs_page,
        maker="judge",
        what=__doc__,
        remedy=_COMMAND,
    )


if __name__ == "__main__":
    sys.exit(main())
