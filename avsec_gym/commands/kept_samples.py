"""What a fit measures, kept beside its file until that is written: an interrupted fit goes on."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from avsec_gym.errors import DataError
from avsec_gym.storage.folder_lock import locked_folder
from avsec_gym.storage.portable_names import portable
from avsec_gym.storage.regular_files import is_there
from avsec_gym.storage.text_files import write_text
from avsec_gym.validation.validation_folder import record_differences

SAMPLES, RECORD = ".samples.jsonl", ".samples.json"
"""What follows the name of a fit's file: what was measured for it, and of what."""


@contextmanager
def kept_samples(path: Path, record: Mapping[str, Any]) -> Iterator[Path]:
    """The file of the samples of a fit, in whose folder no other process writes meanwhile.

    It goes, with its record, when all goes well.

    Args:
        path: The file of the fit.
        record: JSON-able: everything that decides the samples.

    Raises:
        DataError: Samples of something else are kept, or another process writes there.
    """
    samples, own = (path.with_name(path.name + end) for end in (SAMPLES, RECORD))
    remedy = "Take this file away, or name another --fit."
    with locked_folder(path.parent):
        if is_there(samples) and (others := record_differences(own, record, remedy)):
            raise DataError(
                f"What was measured is of something else: {'; '.join(others)}.",
                path=samples,
                remedy=remedy,
            )
        write_text(own, json.dumps(portable(record), indent=1) + "\n", overwrite=True)
        yield samples
        for file in (samples, own):
            file.unlink(missing_ok=True)
