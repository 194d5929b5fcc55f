"""Takes the steps of a study, and records what it was made from."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Mapping
from datetime import date

import avsec_gym
from avsec_gym.console import DONE_IN_PART, say
from avsec_gym.errors import AvsecError
from avsec_gym.storage.text_files import write_text
from studies.kept import forget, take_up
from studies.provenance import Record, read_records, sources_of, write_records
from studies.study import ROOT, Step, Study

Given = Mapping[str, list[str]]
"""What stands for ``$kitti`` and the like in a step: paths, as seen from the checkout."""


def make_anew(study: Study, given: Given) -> None:
    """Take all steps of a study, then record its sources.

    It goes on with what its runs hold, or with what is kept of these in the repository.

    Args:
        study: One of the catalogue.
        given: What the steps need.

    Raises:
        AvsecError: A step failed: its own words stand above.
    """
    begun, sources = time.monotonic(), sources_of(study.sources)
    take_up(study, ROOT / given["runs"][0])
    for number, step in enumerate(study.steps, start=1):
        passed = (time.monotonic() - begun) / 60
        say(
            f"{study.name}: step {number} of {len(study.steps)}, {passed:.0f} min passed, about"
            f" {max(0, study.minutes - passed):.0f} min left: {' '.join(step.filled(given))}"
        )
        _take(step, given)
    if sources_of(study.sources) != sources:
        say(f"{study.name}: sources were changed meanwhile; those of the beginning are recorded")
    record = Record(
        date=date.today().isoformat(),
        version=avsec_gym.__version__,
        command=study.command,
        seconds=round(time.monotonic() - begun),
        sources=sources,
    )
    write_records(read_records() | {study.name: record})
    forget(study)


def _take(step: Step, given: Given) -> None:
    words = list(step.filled(given))
    # In the checkout, where its own packages are found.
    output = subprocess.PIPE if step.to else None
    ended = subprocess.run([sys.executable, *words], cwd=ROOT, check=False, stdout=output)
    # All but some frames, which the page reports, is good enough.
    in_part = ended.returncode == DONE_IN_PART and words[:2] == ["-m", "avsec_gym"]
    if ended.returncode and not in_part:
        raise AvsecError(f"python {' '.join(words)} ended with exit code {ended.returncode}.")
    if step.to:
        write_text(ROOT / step.to, _placeless(ended.stdout.decode(), given), overwrite=True)


def _placeless(text: str, given: Given) -> str:
    """A text without the paths of this machine."""
    text = text.replace(f"{ROOT}/", "")
    for name, paths in given.items():
        for path in paths if name != "runs" else []:
            text = text.replace(path, name.upper())
    return text
