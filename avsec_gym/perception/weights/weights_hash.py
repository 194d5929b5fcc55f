"""Which weights something was fitted, trained or measured with."""

from __future__ import annotations

import hashlib
from typing import Any

from torch import nn


def weights_hash(part: Any) -> str | None:
    """SHA-256 of the weights of a part's `network`; None for one that has none.

    Whatever is fitted to a network (a patch, a likelihood) keeps it, since it
    holds for no other weights of the same network.

    Args:
        part: A detector, a depth estimator, or anything else.

    Example:
        >>> weights_hash("a part without a network") is None
        True
    """
    network = getattr(part, "network", None)
    if not isinstance(network, nn.Module):
        return None
    digest = hashlib.sha256()
    for name, value in sorted(network.state_dict().items()):
        digest.update(f"{name} {value.dtype} {tuple(value.shape)}".encode())
        digest.update(value.detach().cpu().contiguous().numpy().tobytes())
    return digest.hexdigest()
