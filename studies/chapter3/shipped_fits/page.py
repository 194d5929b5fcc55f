"""The page of `judge`, as Markdown.

Run ``python -m studies.chapter3.shipped_fits.page FILE --out PAGE``.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from avsec_gym.drawing.page_table import UNKNOWN, number
from avsec_gym.metrics.clustered_shares import Share
from avsec_gym.report.markdown_table import markdown_table
from avsec_gym.sensor_system import LIDAR
from studies.chapter3.shipped_fits.judge import NO_ATTACK
from studies.chapter3.shipped_fits.judged_result import JudgedFits, JudgedRealFrames, JudgedSystem
from studies.page_of_result import page_of_result

_COMMAND = "Make it with `python -m studies.chapter3.shipped_fits.judge --json FILE`."
_HEADINGS = (
    "attacked", "alarm by thresholds, %", "alarm by likelihood, %", "named by thresholds, %",
    "named by likelihood, %",
)  # fmt: skip


def shipped_page(result: JudgedFits) -> str:
    """The page.

    Args:
        result: The result of `judge`.
    """
    rate = number(100 * result.rate, digits=0)
    lines = [
        "# Validation without clean frames of one's own",
        "",
        "Thresholds and likelihoods that the package ships, judged on procedural drives that"
        " nothing was fitted on, and on real frames of KITTI. Made by"
        " `python -m studies.chapter3.shipped_fits.judge`, shown by its `page`. The"
        f" thesis’ attacks, one draw for each frame; r = {rate} % for each triple; in brackets:"
        " 95 % intervals. Named: exactly the attacked sensor, by likelihoods with 95 % or more.",
        "",
    ]
    for system in result.systems:
        lines += [
            f"## {_listed(system.sensors)}: {result.frames} procedural frames, seed"
            f" {result.seed} of those to judge",
            "",
            f"Thresholds and likelihoods were {system.fitted_on}.",
            "",
            *_table(system),
            "",
        ]
    if result.real is not None:
        lines += _real(result.real, rate)
    return "\n".join(lines)


def _real(real: JudgedRealFrames, rate: str) -> list[str]:
    lines = []
    for id, system in real.frames.items():
        clean = ", ".join(
            f"{name} {value:.3g} of {real.thresholds[name]:.3g}"
            for name, value in (system.clean or {}).items()
        )
        lines += [
            f"## A real frame: {id}, {_listed(system.sensors)}",
            "",
            f"Thresholds and likelihoods were {system.fitted_on}. As it was recorded, of each"
            f" threshold: {clean}. {real.draws} draws of each attack.",
            "",
            *_table(system),
            "",
        ]
        false = [name for name, by in system.by.items() if by[NO_ATTACK].alarms.count]
        if false:
            lines += [
                f"As it was recorded it raises a false alarm by {' and by '.join(false)}: these"
                " were fitted on no real camera. A sensor that is named then is no evidence.",
                "",
            ]
    limit = real.thresholds["brightness"]
    beyond = [id for id, value in real.pairs.items() if value > limit]
    each = ", ".join(f"{id} {value:.3g}" for id, value in real.pairs.items())
    return [
        *lines,
        "## Real pairs of images",
        "",
        f"Other brightness of cameras 3 and 2, as recorded: {each}. Beyond the shipped threshold of"
        f" {limit:.3g} at r = {rate} % are {len(beyond)} of {len(real.pairs)}"
        f"{f' ({chr(44).join(beyond)})' if beyond else ''}: each would be a false alarm. Procedural"
        " frames are cleaner than real ones, so that more real frames raise one than r states.",
        "",
    ]


def _table(system: JudgedSystem) -> list[str]:
    rows = []
    for case in system.by["thresholds"]:
        cells = [system.by[name][case] for name in ("thresholds", "likelihood")]
        words = NO_ATTACK if case == NO_ATTACK else _listed([case])
        # A sensor that is named without an attack is counted with the alarms.
        named = [None if case == NO_ATTACK else judged.named for judged in cells]
        rows.append([words, *(_share(judged.alarms) for judged in cells), *map(_share, named)])
    return markdown_table(_HEADINGS, rows)


def _listed(sensors: Sequence[int | str]) -> str:
    words = ["LiDAR" if sensor == LIDAR else f"camera {sensor}" for sensor in sensors]
    return ", ".join(words)


def _share(share: Share | None) -> str:
    if share is None or share.rate is None or share.interval is None:
        return UNKNOWN
    low, high = (number(100 * bound, 1) for bound in share.interval)
    return f"{number(100 * share.rate, 1)} [{low}, {high}] ({share.count} of {share.of})"


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    return page_of_result(
        arguments, JudgedFits, shipped_page, maker="judge", what=__doc__, remedy=_COMMAND
    )


if __name__ == "__main__":
    sys.exit(main())
