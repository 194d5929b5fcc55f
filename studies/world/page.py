"""`studies/results/world.md`: every figure of it comes from the measurements."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple, dataclass

from studies.world.checks import Checked
from studies.world.frames import Percentiles
from studies.world.images import ImageComparison
from studies.world.labels import LabelComparison, LabelQuantity
from studies.world.occlusion import Agreement, OcclusionThresholds
from studies.world.scans import ScanComparison, ScanSpreads
from studies.world.stereo import MatcherErrorSpreads, StereoDifficulty


@dataclass(frozen=True)
class WorldEvidence:
    """All measurements, and the suite that they are of."""

    suite: str
    seed: int
    stereo: StereoDifficulty
    scans: ScanComparison
    images: ImageComparison
    labels: LabelComparison
    occlusion: OcclusionThresholds
    checks: Checked


def page(result: WorldEvidence) -> str:
    """The results of `evidence.run` as Markdown."""
    parts = (
        _head(result),
        _stereo(result.stereo),
        _scans(result.scans),
        _images(result.images),
        _labels(result.labels),
        _occlusion(result.occlusion),
        _checks(result.checks),
    )
    return "\n\n".join("\n".join(part) for part in parts) + "\n"


def _head(result: WorldEvidence) -> list[str]:
    return [
        "# The procedural world against real KITTI",
        "",
        f"The suite `{result.suite}`, seed {result.seed}, against the real frames named"
        " below. Made by `python -m studies.world.evidence --kitti ROOT`.",
    ]


def _stereo(stereo: StereoDifficulty) -> list[str]:
    lines = [
        "## Stereo matching",
        "",
        f"OpenCV's SGBM (128 disparities, blocks of 5) on {stereo.frames} rendered pairs. A"
        " disparity is wrong if it is off by more than 3 pixels and 5 %; the LiDAR's nearest point"
        " in a pixel counts, and nothing left of column 130.",
        "",
        "![Difficulty of rendered and real pairs](images/world_stereo.png)",
        "",
        "| rendered pairs | mean | 5 % | 25 % | median | 75 % | 95 % |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for pairs, against in (
        (stereo.lidar, "against the LiDAR"),
        (stereo.dense, "against dense truth"),
    ):
        for spread, what, scale, digits in _STEREO:
            values = [_number(value, scale, digits) for value in astuple(spread(pairs))]
            lines.append(f"| {what}, {against} | " + " | ".join(values) + " |")
    lines += [
        "",
        "| real pair | wrong, % | found, % | found of all pixels, % | median error, px |",
        "| --- | --- | --- | --- | --- |",
    ]
    for name, pair in stereo.real.items():
        numbers = (
            _number(pair.wrong, 100, 1),
            _number(pair.density, 100, 1),
            _number(pair.filled, 100, 1),
            _number(pair.median_error, 1, 2),
        )
        lines.append(f"| {name} | " + " | ".join(numbers) + " |")
    return lines


_STEREO: tuple[tuple[Callable[[MatcherErrorSpreads], Percentiles], str, float, int], ...] = (
    (lambda pairs: pairs.wrong, "wrong, %", 100, 1),
    (lambda pairs: pairs.density, "found, %", 100, 1),
    (lambda pairs: pairs.median_error, "median error, px", 1, 2),
)


_SCANS: tuple[tuple[Callable[[ScanSpreads], Percentiles], str, float, int], ...] = (
    (lambda scans: scans.points, "points", 1, 0),
    (lambda scans: scans.mean_reflectance, "mean reflectance", 1, 2),
    (lambda scans: scans.dark, "without reflectance, %", 100, 1),
    (lambda scans: scans.noise_near, "noise of ranges at 4 to 12 m, cm", 100, 2),
    (lambda scans: scans.noise_far, "noise of ranges at 20 to 40 m, cm", 100, 2),
    (lambda scans: scans.residual_2m, "road from planes in squares of 2 m, cm", 100, 2),
    (lambda scans: scans.residual_5m, "the same in squares of 5 m, cm", 100, 2),
    (lambda scans: scans.residual_5m_kerbs, "its 90th percentile (kerbs in it), cm", 100, 1),
    (lambda scans: scans.off_grid, "coordinates from whole millimetres, mm", 1, 3),
)


def _scans(scans: ScanComparison) -> list[str]:
    depth, boxes, ours, real = scans.depth, scans.boxes, scans.scans, scans.real
    rows = [
        (
            what,
            _spread(spread(ours), scale, digits),
            _spread(spread(real), scale, digits) if real else "–",
        )
        for spread, what, scale, digits in _SCANS
    ]
    return [
        "## LiDAR",
        "",
        f"- Of {depth.points:,} points away from depth edges,"
        f" {_number(depth.agree, 100, 2)} % agree with the rendered depth to less than a pixel"
        f" of disparity ({depth.behind_windows:,} more lie behind windows of vehicles, which"
        " pulses pass).",
        f"- Of {boxes.points:,} points on labelled objects, {_number(boxes.inside, 100, 2)} %"
        f" lie in their boxes; {boxes.foreign:,} points of other things lie deep in a box.",
        "",
        f"| scans | {ours.scans} rendered: mean (5 % to 95 %) | {real.scans} real |"
        if real
        else "| scans | rendered: mean (5 % to 95 %) | real |",
        "| --- | --- | --- |",
        *("| " + " | ".join(row) + " |" for row in rows),
        "",
        "![Range, elevation, reflectance and beams](images/world_scans.png)",
    ]


def _images(images: ImageComparison) -> list[str]:
    return [
        "## Images",
        "",
        f"{images.frames} rendered left images and {len(images.real_frames)} real ones; mean"
        " and standard deviation over the images. Detail is what is left between blurs of half"
        " that size and that size; noise is that of the plainest blocks.",
        "",
        "| grey values, 0 to 255 | rendered | real |",
        "| --- | --- | --- |",
        *(
            f"| {each.title} | {_mean(each.ours)} | {_mean(each.real)} |"
            for each in images.quantities.values()
        ),
    ]


def _labels(labels: LabelComparison) -> list[str]:
    return [
        "## Labels",
        "",
        f"{labels.frames} rendered frames against {labels.kitti_frames:,} of KITTI; of"
        " vehicles (car, van, truck, misc) unless said otherwise. *By chance*: the distance of as"
        " many random frames of KITTI from all of them.",
        "",
        "![Labels of rendered and real frames](images/world_labels.png)",
        "",
        "| quantity | distance | rendered to KITTI | by chance | mean, rendered | mean, KITTI |",
        "| --- | --- | --- | --- | --- | --- |",
        *(
            f"| {each.title} | {_kind(each)} | {_short(each.distance)} | {_short(each.yardstick)} |"
            f" {_short(each.mean_ours)} | {_short(each.mean_kitti)} |"
            for each in labels.quantities.values()
        ),
    ]


def _occlusion(occlusion: OcclusionThresholds) -> list[str]:
    used, best = occlusion.in_use, occlusion.best
    names = ("visible", "partly", "largely")
    return [
        "## Occlusion levels",
        "",
        f"Twins of {occlusion.frames} real frames tell how much of {occlusion.objects} real"
        " vehicles is seen; the annotators' levels (rows) against ours (columns):",
        "",
        "| annotated | " + " | ".join(names) + " |",
        "| --- | --- | --- | --- |",
        *(
            f"| {name} | " + " | ".join(map(str, row)) + " |"
            for name, row in zip(names, used.confusion, strict=True)
        ),
        "",
        f"They agree on {_number(used.agreement, 100, 1)} % (kappa {used.kappa:.2f}) with the"
        f" thresholds {_pair(used)} in use; at best, with {_pair(best)}, on"
        f" {_number(best.agreement, 100, 1)} % (kappa {best.kappa:.2f}). Annotators also call"
        " objects occluded behind what has no label, which a twin does not know.",
    ]


def _checks(checks: Checked) -> list[str]:
    return [
        "## What must not be seen",
        "",
        f"{checks.frames} frames with {checks.actors} actors, those behind the camera included.",
        "",
        "| check | found |",
        "| --- | --- |",
        f"| actors whose middle is more than 3 cm above / below the ground | {checks.floating} /"
        f" {checks.sunk} |",
        "| actors of which a wheel or foot is more than 5 cm above / below the ground |"
        f" {checks.feet_in_the_air} / {checks.feet_in_the_ground} |",
        f"| pairs of actors in one another | {checks.overlapping_pairs} |",
        f"| actors with scenery in them | {checks.pierced} |",
        "| actors in the sun whose shadow begins where they stand |"
        f" {_number(checks.contact_shadows, 100, 1)} % |",
        "| road far ahead off its place in the image, median |"
        f" {_number(checks.horizon_error, 1, 2)} px |",
        "| road texture like itself some metres on, highest correlation |"
        f" {_number(checks.largest_repeat, 1, 2)} (above the bound in"
        f" {checks.repeating} frames) |",
    ]


def _number(value: float | None, scale: float, digits: int) -> str:
    return "–" if value is None else f"{scale * value:,.{digits}f}"


def _short(value: float | None) -> str:
    return "–" if value is None else f"{value:.3g}"


def _spread(values: Percentiles, scale: float, digits: int) -> str:
    mean, low, high = (
        _number(value, scale, digits) for value in (values.mean, values.p5, values.p95)
    )
    return f"{mean} ({low} to {high})"


def _mean(values: tuple[float, float] | None) -> str:
    return "–" if values is None else f"{values[0]:.2f} ± {values[1]:.2f}"


def _kind(quantity: LabelQuantity) -> str:
    if quantity.kind == "variation":
        return "total variation"
    return f"Wasserstein, {quantity.unit}" if quantity.unit else "Wasserstein"


def _pair(agreed: Agreement) -> str:
    return " and ".join(f"{threshold:.2f}" for threshold in agreed.thresholds)
