"""Seconds of `avsec evaluate`, process start included; prints JSON.

    python benchmarks/evaluate.py [--kitti ROOT --scenarios DIR]

Without arguments it drives 600 procedural layouts.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import time

RUNS = 5


def main() -> None:
    """Measure, print JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kitti")
    parser.add_argument("--scenarios")
    arguments = parser.parse_args()
    command = [sys.executable, "-m", "avsec_gym", "evaluate", "--json"]
    if arguments.scenarios:
        command += ["--scenarios", arguments.scenarios]
        command += ["--kitti", arguments.kitti] if arguments.kitti else []
    else:
        command += ["--scenarios", "layouts", "--limit", "600"]
    seconds = []
    for _ in range(RUNS + 1):
        begun = time.perf_counter()
        report = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
        seconds.append(time.perf_counter() - begun)
    first, *warm = seconds
    drives = sum(row["scenarios"] for row in report["rates"])
    result = {
        "scenario_set": report["scenario_set"],
        "drives": drives,
        "first_seconds": round(first, 2),
        "median_seconds": round(statistics.median(warm), 2),
        "runs": RUNS,
    }
    print(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
