"""Has every detector look at the drives, left alone and attacked.

Run ``python -m studies.driving_safety.error_models.detect --runs DIR``; a run that was stopped goes
on where it was.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from avsec_gym import console
from avsec_gym.perception.result_folder import write_result_folder
from studies.answer import exit_code
from studies.driving_safety.error_models.cases import CHECK, FIT, cases


def detect(runs: Path) -> None:
    """Write the detections of every case.

    Args:
        runs: The folder of the study, which holds the drives of `FIT` and `CHECK`.

    Raises:
        DataError: Drives are missing, or the folder holds other detections.
    """
    for case in cases():
        for of in (FIT, CHECK):
            for kitti, detections in case.folders(runs, of):
                with console.progress(f"{case.name}: {of} {kitti.name}") as shown:
                    write_result_folder(
                        kitti, case.ids(kitti), case.asked, detections, on_progress=shown
                    )


def main(arguments: Sequence[str] | None = None) -> int:
    """The command."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--runs", type=Path, required=True, help="folder of the study")
    options = parser.parse_args(arguments)
    return exit_code(lambda: detect(options.runs))


if __name__ == "__main__":
    sys.exit(main())
