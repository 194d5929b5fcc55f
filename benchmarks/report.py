"""Runs the benchmarks and writes studies/results/benchmarks.json and benchmarks.md.

    python benchmarks/report.py [--out studies/results] [--scenarios DIR]
        [--planning DIR --original PATH]

``--scenarios`` adds the labelled KITTI scenarios; ``--planning`` a folder with ``scenarios/``,
``scenarios_wide/`` and ``primitives/`` of CommonRoad files, ``--original`` a checkout of
commonroad-search.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
PLANNER_SETS = (
    ("scenarios/*_6_8_*.xml", "street_v6_sa7.xml"),
    ("scenarios/*_11_13_*.xml", "highway_v11_13_sa7.xml"),
    (
        "scenarios_wide/*.xml",
        "V_0.0_20.0_Vstep_2.0_SA_-1.066_1.066_SAstep_0.18_T_0.5_Model_BMW_320i.xml",
    ),
)
"""Files and motion primitives that belong together, below --planning."""


def run(script: str, *arguments: str) -> Any:
    """One benchmark in a process of its own."""
    command = [sys.executable, str(HERE / script), *arguments]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)


def main() -> None:
    """Run everything, write both files."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("studies/results"))
    parser.add_argument("--scenarios")
    parser.add_argument("--planning", type=Path)
    parser.add_argument("--original")
    options = parser.parse_args()
    results: dict[str, Any] = {
        "machine": f"{platform.machine()}, {os.cpu_count()} cores, Python"
        f" {platform.python_version()}",
        "environment": run("ghost_object.py"),
        "layouts": run("layouts.py"),
        "evaluate": [run("evaluate.py")],
    }
    if options.scenarios:
        results["evaluate"].append(run("evaluate.py", "--scenarios", options.scenarios))
    if options.planning:
        original = ["--original", options.original, "--repeat", "10"] if options.original else []
        results["planner"] = [
            run(
                "planner.py",
                "--scenarios",
                str(options.planning),
                "--primitives",
                str(options.planning / "primitives" / primitives),
                "--pattern",
                pattern,
                *original,
            )
            for pattern, primitives in PLANNER_SETS
        ]
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "benchmarks.json").write_text(json.dumps(results, indent=1) + "\n")
    (options.out / "benchmarks.md").write_text(page(results))


def page(results: dict[str, Any]) -> str:
    """The results as Markdown."""
    environment = results["environment"]
    lines = [
        "# Benchmarks",
        "",
        f"On {results['machine']}; made by `python benchmarks/report.py`. Shared machines are"
        " noisy:"
        " read these as orders of magnitude, and the ratios as ratios of one run.",
        "",
        "| what | measured |",
        "| --- | --- |",
        *environment_rows(environment),
        f"| procedural layouts, one core | {results['layouts']['layouts_per_second']} /s |",
        *(
            f"| `avsec evaluate`, {row['scenario_set']}: {row['drives']} drives, process start"
            f" included, median of {row['runs']} | {row['median_seconds']} s |"
            for row in results["evaluate"]
        ),
    ]
    if "planner" in results:
        lines += ["", "## The same files planned by commonroad-search, in the same run", ""]
        lines += planner_table(results["planner"])
    return "\n".join(lines) + "\n"


def environment_rows(environment: dict[str, Any]) -> list[str]:
    """Steps a second of each version, single and batched."""
    rows = []
    for id, figures in environment.items():
        steps = figures["single"]["steps_per_second"]
        rows.append(f"| `{id}`, CPU time of one core, random actions | {steps} steps/s |")
        rows += [
            f"| the same, {count} in a batch | {batched} steps/s |"
            for count, batched in figures["batched_steps_per_second"].items()
        ]
    return rows


def ratio_of_many_nodes(summary: dict[str, Any]) -> str:
    """The ratio of the long searches, and how many there are."""
    rows, many = summary["rows_of_many_nodes"], summary["many_nodes"]
    if not rows:
        return f"none of {many}"
    return f"{summary['speed_ratio_of_many_nodes']:.0f} ({rows} of {many} nodes or more)"


def planner_table(runs: list[dict[str, Any]]) -> list[str]:
    """Ours and the original's, a row for each set of primitives."""
    lines = [
        "| primitives | rows | same nodes and cost | ours, median | ours, a node | original, a node"
        " | original / ours, median | total | total of searches of many nodes |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for (_, primitives), result in zip(PLANNER_SETS, runs, strict=True):
        summary = result["summary"]
        compared = summary.get("compared")
        lines.append(
            f"| {primitives} | {summary['rows']} | "
            + (f"{summary['same_nodes_and_cost']} of {compared}" if compared else "–")
            + f" | {1e6 * summary['ours_seconds_median']:.0f} µs"
            + f" | {summary['ours_microseconds_a_node']:.2f} µs | "
            + (
                f"{summary['original_microseconds_a_node']:.0f} µs | "
                f"{summary['speed_ratio_median']:.0f} | {summary['speed_ratio_total']:.0f} | "
                + ratio_of_many_nodes(summary)
                + " |"
                if compared
                else "– | – | – | – |"
            )
        )
    timeouts = sum(result["summary"].get("original_timeouts", 0) for result in runs)
    if timeouts:
        lines += ["", f"Rows that commonroad-search did not finish in time: {timeouts}."]
    return lines


if __name__ == "__main__":
    main()
