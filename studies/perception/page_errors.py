"""Parts of studies/results/detectors.md: why precision is lost, and frames to look at."""

from __future__ import annotations

from collections.abc import Mapping

from avsec_gym.metrics.working_point import Counts
from avsec_gym.report.markdown_table import markdown_table, number, share
from studies.perception.corrected_detections import CorrectedPrecision
from studies.perception.detection_errors import DistanceErrors, ErrorSpread
from studies.perception.detector_precision import DetectorPrecision, ScoredDetector
from studies.perception.detector_scores import DistancePrecision

_KINDS = {
    "nothing": "as found",
    "depth": "depth right",
    "sideways": "direction right, left or right",
    "upwards": "direction right, up or down",
    "yaw": "yaw right",
    "size": "size right",
    "whole box": "all of these right",
    "score": "the surer, the better the box",
    "false alarms": "no false alarms",
    "all but misses": "all boxes right, no false alarms",
}
_SINGLE = ("depth", "sideways", "upwards", "yaw", "size", "score", "false alarms")
_ERRORS = {
    "depth": ("depth", "m"),
    "sideways": ("sideways", "m"),
    "upwards": ("upwards", "m"),
    "yaw": ("yaw", "°"),
    "height": ("height", "m"),
    "width": ("width", "m"),
    "length": ("length", "m"),
}


def reasons(scores: DetectorPrecision) -> list[str]:
    """What is found at all, how far off it is, and what correcting that would give."""
    detectors = scores.detectors
    return [
        "## Why precision is lost",
        "",
        *_seen_and_errors(detectors),
        "",
        *_corrected(detectors),
        "",
        " ".join(_costliest(name, figures.scores.corrected) for name, figures in detectors.items()),
    ]


def _seen_and_errors(detectors: Mapping[str, ScoredDetector]) -> list[str]:
    """Two tables, a line for each detector and range of distance that holds cars."""
    seen, errors = [], []
    for name, figures in detectors.items():
        for part in figures.scores.errors:
            if not part.cars:
                continue
            head = [f"`{name}`", metres(part), str(part.cars)]
            seen.append([*head, share(part.seen), *map(share, part.overlap.values())])
            cells = [_error(part.errors[kind], unit) for kind, (_, unit) in _ERRORS.items()]
            errors.append([*head[:2], *cells, share(part.reversed)])
    return [
        "How many of the cars to find (moderate) are seen in the image (boxes share half), and how"
        " many any detection overlaps from above by more than so much; all detections count,"
        " however unsure.",
        "",
        *markdown_table(
            ["detector", "metres", "cars", "seen, %", "IoU > 0.25, %", "> 0.5, %", "> 0.7, %"], seen
        ),
        "",
        "Errors of those seen: median (with sign) / median size / size that 90 % stay below."
        " Sideways and upwards are errors of the direction in which the box is seen.",
        "",
        *markdown_table(
            ["detector", "metres", *(f"{title}, {unit}" for title, unit in _ERRORS.values()),
             "reversed, %"],
            errors,
        ),
    ]  # fmt: skip


def _corrected(detectors: Mapping[str, ScoredDetector]) -> list[str]:
    """A table of the precision with one kind of error corrected, a line for each kind."""
    titles = [f"`{name}` {where}" for name in detectors for where in ("in space", "from above")]
    kinds = [
        [
            title,
            *(
                number(value, 1)
                for figures in detectors.values()
                for corrected in (figures.scores.corrected[kind],)
                for value in (corrected.in_space, corrected.from_above)
            ),
        ]
        for kind, title in _KINDS.items()
    ]
    return [
        "What AP11 (moderate, IoU 0.7) would be if one kind of error were corrected by the labels"
        " and all else stayed:",
        "",
        *markdown_table(["corrected", *titles], kinds),
    ]


def _costliest(name: str, corrected: Mapping[str, CorrectedPrecision]) -> str:
    """A detector's costliest single error, and the price of the cars that it misses."""
    precision = {kind: values.in_space for kind, values in corrected.items()}
    best = max(_SINGLE, key=precision.__getitem__)
    return (
        f"Of single errors of `{name}`, most is lost by {_lost(best)}:"
        f" {precision['nothing']:.1f} would be {precision[best]:.1f}."
        f" Cars that it does not see cost {100 - precision['all but misses']:.1f}."
    )


def examples(scores: DetectorPrecision) -> list[str]:
    """Frames chosen by rule; nothing where none were drawn."""
    chosen = scores.examples
    if not chosen:
        return []
    points = {name: figures.scores.working_point for name, figures in scores.detectors.items()}
    lines = [
        "## Pictures",
        "",
        f"The {chosen[0].of} frames with three or more cars to find, ordered by how right all"
        " detectors together are (F1, IoU 0.5 from above): the best, the median, the worst. Shown"
        " are boxes from the score at which a detector's F1 over all frames is best: "
        + "; ".join(
            f"`{name}` {point.score:.2f} (precision {100 * point.precision:.0f} %, recall"
            f" {100 * point.recall:.0f} %)"
            if point
            else f"`{name}` none"
            for name, point in points.items()
        )
        + ".",
    ]
    for example in chosen:
        counts = "; ".join(f"`{name}` {_counts(count)}" for name, count in example.counts.items())
        lines += ["", f"Frame {example.frame}, the {example.rank}: {counts}."]
        lines += ["", f"![The {example.rank} frame](images/detections_{example.rank}.jpg)"]
    return lines


def metres(part: DistanceErrors | DistancePrecision) -> str:
    """A range of distance."""
    near, far = part.near, part.far
    if far is None:
        return f"{near:g} and more" if near else "all"
    return f"{near:g} to {far:g}"


def _error(spread: ErrorSpread, unit: str) -> str:
    digits = 1 if unit == "°" else 2
    values = (spread.median, spread.median_size, spread.size_of_90)
    return " / ".join(number(value, digits) for value in values)


def _lost(kind: str) -> str:
    return {"sideways": "the direction sideways", "upwards": "the direction upwards",
            "score": "the order of scores"}.get(kind, kind)  # fmt: skip


def _counts(counts: Counts) -> str:
    return f"{counts.found} found, {counts.missed} missed, {counts.false_alarms} false alarms"
