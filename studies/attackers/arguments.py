"""Options of the studies that train an attacker on sensors."""

from __future__ import annotations

import argparse
import json
from typing import Any

from studies.attackers.searches import FEWEST_STEPS


def arguments(description: str) -> argparse.ArgumentParser:
    """A parser with the options that they have in common.

    Args:
        description: What the command does, a sentence.
    """
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--detector", default="dsgn", help="name, or JSON with its arguments")
    parser.add_argument("--threshold", type=float, default=0.3, help="of the detector's scores")
    parser.add_argument("--steps", type=_enough, default=1000, help="training queries")
    parser.add_argument("--held-out", type=int, default=30, help="episodes or scenes to judge by")
    parser.add_argument("--seed", type=int, default=0)
    # Neither layouts nor assets of held-out scenes are learned from.
    for name, split, assets in (("training", "train", "train"), ("testing", "val", "judge")):
        scenes = json.dumps({"source": "mixed", "split": split, "assets": assets})
        parser.add_argument(f"--{name}", default=scenes, help="suite, folder, or JSON")
    return parser


def given(text: str) -> Any:
    """A name, or a dictionary as JSON."""
    return json.loads(text) if text.startswith("{") else text


def _enough(text: str) -> int:
    """Training queries, so many that both searches try something."""
    if int(text) < FEWEST_STEPS:
        raise argparse.ArgumentTypeError(f"{FEWEST_STEPS} queries or more, got {text}")
    return int(text)
