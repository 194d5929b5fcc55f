"""Error models that the package ships, by the names of detector and attack.

`python -m studies error_models` fits them, and holds them against drives that they were not fitted
to.
"""

from __future__ import annotations

import logging
from pathlib import Path

from avsec_gym.closed_loop.error_model.model import ErrorModel, read_error_model
from avsec_gym.perception.weights.weights_file import weights_file_hash
from avsec_gym.storage.regular_files import is_there
from avsec_gym.unknown_source import unknown_source

SHIPPED_MODELS = Path(__file__).parent / "shipped_models"
"""The folder of the files."""
_LOG = logging.getLogger(__name__)
_REPORTED: set[str] = set()


def shipped_error_models() -> tuple[str, ...]:
    """The names of all that are shipped: a detector's, or a detector's and its attack's.

    Example:
        >>> "stereo_rcnn" in shipped_error_models()
        True
    """
    return tuple(sorted(path.stem for path in SHIPPED_MODELS.glob("*.json")))


def named_error_model(model: str | Path) -> ErrorModel:
    """A shipped error model by its name, any other by its file.

    One that was fitted to other weights of the detector than the package has now still holds for
    those; that is logged, once.

    Args:
        model: The name, such as ``stereo_rcnn``, or the file of `avsec error-model fit`.

    Raises:
        DataError: The file is missing, damaged, or something else.
    """
    path = error_model_file(model)
    found = read_error_model(path)
    today = weights_file_hash(found.card.get("detector"))
    fitted = found.card.get("weights")
    # One of your own detector, or of detections of unknown weights, may be of any.
    is_known = path.parent == SHIPPED_MODELS or (fitted is not None and today is not None)
    if is_known and fitted != today and str(model) not in _REPORTED:
        _REPORTED.add(str(model))
        _LOG.warning(
            "the error model %s was fitted to other weights (%s) than the detector has now (%s):"
            " `avsec error-model fit` makes one of these",
            model,
            str(fitted)[:8],
            str(today)[:8],
        )
    return found


def error_model_file(model: str | Path) -> Path:
    """The file of an error model.

    Args:
        model: The file or the name, as for `named_error_model`.

    Raises:
        ConfigurationError: It is the name of a shipped one, mistyped.
        DataError: There is none.
    """
    known = shipped_error_models()
    if str(model) in known:
        return SHIPPED_MODELS / f"{model}.json"
    if not is_there(model):
        expected = f"Name a file, or a shipped error model: {', '.join(known)}."
        raise unknown_source(str(model), known, expected)
    return Path(model)
