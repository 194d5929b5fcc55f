"""States that shipped fits hold for today's code, where it measures what they were made of.

Run ``python -m studies.chapter3.shipped_fits.confirm`` after a change of the code
that is to change no figure: the first frames are rendered and measured again. A change that does is
for `fit`, and for `avsec_gym.validation.fitted_on.FORMAT`.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from avsec_gym.errors import DataError
from avsec_gym.experiments.chapter3.recordings import FITTED
from avsec_gym.storage.atomic_write import write_bytes
from avsec_gym.storage.json_files import read_json_object
from avsec_gym.validation.evidence.pair_depth import PairDepth
from avsec_gym.validation.recordings import raw_recordings
from avsec_gym.validation.shipped import FITS, evidence_sources, shipped_file
from avsec_gym.validation.thresholds import read_threshold_table, shares_of
from avsec_gym.world.assets import Assets
from studies.answer import exit_code
from studies.chapter3.shipped_fits.evidence import SYSTEM, shipped_drives

_SAME = 1e-4
"""The tolerance of a share of the pixels: libraries round otherwise here and there."""


def confirm_fits(frames: int, fits: Path) -> None:
    """Measure the first clean frames again, and write today's sources into all files.

    Args:
        frames: How many.
        fits: Folder of the files.

    Raises:
        DataError: A frame measures otherwise; or a file is not there, or cannot be written.
    """
    path = shipped_file("thresholds", SYSTEM, fits)
    table = read_threshold_table(path)
    data = table.on.data
    # Fits of before there was a choice are of all assets.
    assets = Assets(data.get("assets", Assets.ALL))
    root = shipped_drives(frames, int(data["seed"]), FITTED, assets)
    depth = PairDepth.from_settings(table.on.depth)
    for number, recorded in enumerate(raw_recordings(root, SYSTEM.sensors).frames[:frames]):
        away = np.abs(shares_of(recorded.frame(), SYSTEM, depth) - table.shares[number]).max()
        if away > _SAME:
            raise DataError(
                f"Frame {number} measures otherwise than when this was fitted, by {away:.2g}.",
                path=path,
                remedy="Fit anew: python -m studies.chapter3.shipped_fits.fit.",
            )
    for path in sorted(fits.glob("*.json")):
        content = read_json_object(path, remedy="Fit anew.")
        content["fitted_on"]["data"]["sources"] = evidence_sources()
        write_bytes(path, json.dumps(content, allow_nan=False).encode(), overwrite=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--frames", type=int, default=3, help="to measure again")
    parser.add_argument("--fits", type=Path, default=FITS, help="folder of the files")
    options = parser.parse_args(arguments)
    return exit_code(lambda: confirm_fits(options.frames, options.fits))


if __name__ == "__main__":
    sys.exit(main())
