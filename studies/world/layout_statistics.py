"""How closely the generated layouts match KITTI: the comparison as JSON and as a figure.

Run ``python -m studies.world.layout_statistics --kitti ROOT --scenarios DIR``.
"""

from __future__ import annotations

import argparse
import json
import logging
import sys
from collections.abc import Sequence
from pathlib import Path

from avsec_gym.errors import AvsecError
from avsec_gym.experiments.json_rows import row_json
from studies.world.layout_comparison import compare_with_kitti
from studies.world.layout_figure import draw

_LOG = logging.getLogger(__name__)


def main(arguments: Sequence[str] | None = None) -> int:
    """Write ``layout_statistics.json`` and ``layout_statistics.png``; returns the exit code."""
    parser = argparse.ArgumentParser(description="Compare the generated layouts with KITTI.")
    parser.add_argument("--kitti", type=Path, required=True, help="root of the object benchmark")
    parser.add_argument("--scenarios", type=Path, help="labelled driving-safety scenarios")
    parser.add_argument("--out", type=Path, default=Path("docs/images"), help="for the figure")
    parser.add_argument(
        "--results", type=Path, default=Path("studies/results"), help="for the JSON file"
    )
    parser.add_argument("--count", type=int, default=7481, help="layouts to generate")
    parser.add_argument("--seed", type=int, default=0, help="of the set of layouts")
    options = parser.parse_args(arguments)
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    try:
        result, ours, kitti = compare_with_kitti(
            options.kitti, options.scenarios, options.count, options.seed
        )
    except AvsecError as error:
        _LOG.error("%s", error)
        return 1
    for folder in (options.out, options.results):
        folder.mkdir(parents=True, exist_ok=True)
    target = options.results / "layout_statistics.json"
    target.write_text(json.dumps(row_json(result), indent=2) + "\n")
    figure = draw(result, ours, kitti, options.out / "layout_statistics.png")
    _LOG.info("wrote %s and %s", target, figure)
    return 0


if __name__ == "__main__":
    sys.exit(main())
