"""Parts of studies/results/detectors.md: precision by distance, by occlusion, and by assets."""

from __future__ import annotations

from avsec_gym.report.markdown_table import interval, markdown_table
from studies.perception.detector_precision import DetectorPrecision
from studies.perception.detector_scores import DistancePrecision, OcclusionPrecision
from studies.perception.page_errors import metres
from studies.perception.page_frames import assets_of

_SPACES = ("in space, 0.7", "in space, 0.5", "from above, 0.7", "from above, 0.5")
_HIDDEN = {0: "fully visible", 1: "partly hidden", 2: "largely hidden"}


def by_distance(scores: DetectorPrecision) -> list[str]:
    """Ranges of distance that hold enough cars."""
    rows = [
        [f"`{name}`", metres(part), str(part.cars), *_spaces(part)]
        for name, figures in scores.detectors.items()
        for part in figures.scores.by_distance
        if part.strict
    ]
    return [
        "## By distance",
        "",
        "AP11 of the cars at a range of distance ahead, moderate. Ranges with too few cars for"
        " KITTI's recall points are left out.",
        "",
        *markdown_table(["detector", "metres", "cars", *_SPACES], rows),
    ]


def by_occlusion(scores: DetectorPrecision) -> list[str]:
    """Levels of occlusion that enough cars have; nothing of an earlier result, which has none."""
    rows = [
        [f"`{name}`", _HIDDEN[part.occlusion], str(part.cars), *_spaces(part)]
        for name, figures in scores.detectors.items()
        for part in figures.scores.by_occlusion or ()
        if part.strict
    ]
    if not rows:
        return []
    return [
        "## By occlusion",
        "",
        "AP11 of the cars that others hide so much, by the hard level's least height and most"
        " truncation. Each line has all false alarms of the detector, since what overlaps no car is"
        " hidden by nothing.",
        "",
        *markdown_table(["detector", "the car is", "cars", *_SPACES], rows),
    ]


def _spaces(part: DistancePrecision | OcclusionPrecision) -> list[str]:
    """The cells of `_SPACES`."""
    assert part.strict, "left out where it has none"
    assert part.loose, "there where the other is"
    return [
        interval(values[metric].ap11, values[metric].ap11_interval)
        for metric in ("3d", "bev")
        for values in (part.strict, part.loose)
    ]


def by_assets(scores: DetectorPrecision) -> list[str]:
    """Both parts of the assets, where another one than the judged was looked at."""
    other = scores.other_part
    if other is None:
        return []
    rows = [
        [
            f"`{name}`",
            iou,
            *(interval(each.value, each.interval) for each in (part.judged, part.other)),
            interval(part.difference.value, part.difference.interval),
        ]
        for name, figures in scores.detectors.items()
        for iou, part in (figures.parts or {}).items()
    ]
    titles = [assets_of(data) for data in (scores.data, other)]
    return [
        "## By assets",
        "",
        f"AP11 of cars in space, moderate, on the {scores.data.frames} frames of this page and on"
        f" {other.frames} others (suite `{other.suite}`, seed {other.seed}). Intervals of a column"
        " are over the scenes of its part: they hold for more scenes of these assets, and know"
        " nothing of others. The difference has an interval of its own, over the scenes of"
        " both parts.",
        "",
        *markdown_table(["detector", "IoU", *titles, "difference"], rows),
    ]
