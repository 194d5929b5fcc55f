"""Procedural layouts a second on one core; prints JSON.

python benchmarks/layouts.py
"""

from __future__ import annotations

import json
import time

from avsec_gym.world.layouts import generate_layouts

COUNT = 1000


def main() -> None:
    """Measure, print JSON."""
    generate_layouts(10)
    begun = time.perf_counter()
    generate_layouts(COUNT)
    print(json.dumps({"layouts_per_second": round(COUNT / (time.perf_counter() - begun))}))


if __name__ == "__main__":
    main()
