"""Train an attacker that chooses where a patch stands, and judge it on held-out scenes.

    python examples/train_patch_attacker.py
    python examples/train_patch_attacker.py --detector stereo_rcnn --patch patch.safetensors

Everything else is as in `train_perturbation_attacker.py`.
"""

from __future__ import annotations

import json

from train_perturbation_attacker import arguments, compare


def main() -> None:
    """Train, evaluate, print JSON."""
    parser = arguments(__doc__.splitlines()[0])
    parser.add_argument("--patch", help="grey, noise, or a file; without: the detector's own")
    options = parser.parse_args()
    result = compare("avsec/PatchAttack-v0", options, patch=options.patch)
    print(json.dumps(result | {"patch": options.patch or "the detector's own"}, indent=1))


if __name__ == "__main__":
    main()
