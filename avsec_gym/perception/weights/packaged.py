"""Where a network's weights are: in the package, or where the user says."""

from __future__ import annotations

from pathlib import Path

from avsec_gym.errors import DataError


def weights_file(network: str, preset: str, given: str | Path | None = None) -> Path:
    """The file of weights for a network's preset.

    Args:
        network: Such as ``dsgn``.
        preset: Such as ``small``.
        given: The user's own file; the package's if None.

    Raises:
        DataError: There is none.
    """
    path = Path(given or Path(__file__).parent / f"{network}_{preset}.safetensors")
    if not path.is_file():
        raise DataError(
            f"There are no weights of {network} ({preset}) here.",
            path=path,
            remedy=f"Train them: avsec train {network}; or take published ones: "
            f"avsec weights import FILE --network {network}.",
        )
    return path
