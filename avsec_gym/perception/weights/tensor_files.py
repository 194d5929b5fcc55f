"""Files of safetensors, of a bounded size and with one kind of error."""

from __future__ import annotations

from pathlib import Path

from safetensors import SafetensorError
from safetensors.torch import load
from torch import Tensor

from avsec_gym.errors import DataError
from avsec_gym.storage.regular_files import read_bytes

_MOST_BYTES = 4 * 2**30


def read_tensors(path: str | Path, *, remedy: str) -> tuple[dict[str, Tensor], bytes]:
    """The tensors of a file by name, and its bytes.

    Args:
        path: A ``.safetensors`` file.
        remedy: What a user can do about a damaged one.

    Raises:
        DataError: The file cannot be read, or is none of safetensors.
    """
    content = read_bytes(path, most=_MOST_BYTES)
    try:
        return load(content), content
    # The header is checked by the library; types that torch lacks, and numbers that do not fill
    # their shapes, only as the tensors are made.
    except (SafetensorError, KeyError, ValueError, RuntimeError, OverflowError) as error:
        raise DataError(
            f"The file is no sound one of safetensors ({error}).", path=path, remedy=remedy
        ) from error
