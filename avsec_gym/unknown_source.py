"""Where data should be and is nothing: a name that was mistyped, or a path that is not there."""

from __future__ import annotations

import os
from collections.abc import Sequence

from avsec_gym.errors import AvsecError, ConfigurationError, DataError
from avsec_gym.suggestions import did_you_mean


def unknown_source(
    name: str, known: Sequence[str], expected: str, kind: str = "data"
) -> AvsecError:
    """The error of a text that is neither a name, as of data, nor a place that is there.

    A word that reads like a name is that name mistyped; everything else is a missing folder or
    file, as anywhere.

    Args:
        name: What was asked for.
        known: Names that may stand for it.
        expected: What to name instead, as a remedy.
        kind: What the names are of.

    Returns:
        A `ConfigurationError` with the name that may have been meant, or a `DataError`.

    Example:
        >>> print(unknown_source("layuots", ["layouts"], "Name a folder of labels."))
        there is no data "layuots". Did you mean "layouts"? Name a folder of labels.
        >>> print(unknown_source("my/layouts", ["layouts"], "Name a folder of labels."))
        my/layouts: There is no such file or folder. Name a folder of labels.
    """
    if os.sep not in name and (nearest := did_you_mean(name, known)):
        return ConfigurationError(f'there is no {kind} "{name}". {nearest} {expected}')
    return DataError("There is no such file or folder.", path=name, remedy=expected)
