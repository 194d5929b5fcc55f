"""Milliseconds and bytes that an instant of connected vehicles takes, by steps; prints JSON.

    python benchmarks/connected.py [--instants 12]
    python benchmarks/connected.py --page RESULT.json    # what that printed, as a page

CPU time on one core, of all vehicles together as if one computer did the work of them all, and of
the base station: instants of the procedural world, attack-free and with a ghost in one scan, judged
by rays.  One round before compiles the kernels.
"""

from __future__ import annotations

import argparse
import json
import os
import statistics
import time
from pathlib import Path
from typing import Any

# Idle threads of the linear algebra would count as work (before NumPy is loaded).
os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

from avsec_gym.console import progress
from avsec_gym.report.markdown_table import markdown_table
from avsec_gym.rig import camera_rig
from avsec_gym.validation.connected import traffic
from avsec_gym.validation.connected.attacks.pasted_object import PastedObject
from avsec_gym.validation.connected.fit import SHIPPED_FIT, read_connected_fit
from avsec_gym.validation.connected.recordings import RecordedInstant, recorded_instants
from avsec_gym.validation.connected.validator import ConnectedValidator
from avsec_gym.world.assets import Assets
from avsec_gym.world.export import ConnectedWorld, Sensors, cached, suite_recipe

VEHICLES = (2, 3, 5)
SEED = 4242
RIG = camera_rig((0.0, 0.54, 0.06, 0.6), focal_length=80.0, centre=(64.0, 24.0), size=(128, 48))
"""Scans alone are looked at: images are small."""
STEPS = ("propose", "merge", "claim", "witness", "decide")
ALARMS = 0.1


def main() -> None:
    """Render, measure, print JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], allow_abbrev=False)
    parser.add_argument("--instants", type=int, default=12, help="for each number of vehicles")
    parser.add_argument("--page", type=Path, help="print this result as Markdown instead")
    options = parser.parse_args()
    if options.page is not None:
        print("\n".join(page(json.loads(options.page.read_text()))))
        return
    rows = {}
    sets = {vehicles: rendered(vehicles, options.instants) for vehicles in VEHICLES}
    with progress("compiling") as shown:
        measured(sets[VEHICLES[-1]], shown)
    for vehicles, instants in sets.items():
        with progress(f"{vehicles} vehicles") as shown:
            rows[str(vehicles)] = measured(instants, shown)
    print(json.dumps({"instants": options.instants, "vehicles": rows}, indent=1))


def rendered(vehicles: int, count: int) -> list[RecordedInstant]:
    """Instants of the procedural world, in the cache from then on."""
    recipe = suite_recipe(
        "connected",
        count,
        SEED,
        sensors=Sensors((2,), rig=RIG),
        vehicles=vehicles,
        assets=Assets.JUDGE,
    )
    with progress(f"rendering {vehicles} vehicles") as shown:
        root = cached(f"connected-{vehicles}-{SEED}-{count}", recipe, on_progress=shown)
    return list(recorded_instants(ConnectedWorld(root)))


def measured(instants: list[RecordedInstant], shown: Any) -> dict[str, Any]:
    """Medians over instants, of CPU time and of bytes."""
    # Steps are measured by the wall clock; here, by what they cost.
    traffic.time.perf_counter = time.process_time  # type: ignore[attr-defined]
    validator = ConnectedValidator(read_connected_fit(SHIPPED_FIT).constants(alarms=ALARMS))
    each = []
    for number, instant in enumerate(instants):
        attacked = PastedObject().attack(instant, SEED + number)
        for scans in (instant.scans, None if attacked is None else attacked.instant.scans):
            if scans is not None:
                each.append(validator.validate(scans, id=instant.id).traffic)
        shown(number + 1, len(instants))
    steps = {
        step: 1000 * statistics.median(sent.seconds.get(step, 0.0) for sent in each)
        for step in STEPS
    }
    after = [1000 * sum(sent.seconds[step] for step in STEPS[1:]) for sent in each]
    totals = [vehicle.total() for sent in each for vehicle in sent.sent]
    return {
        "milliseconds": {step: round(value, 1) for step, value in steps.items()},
        "after proposals": {
            "median": round(statistics.median(after), 1),
            "largest": round(max(after), 1),
        },
        "bytes of a vehicle": {"median": round(statistics.median(totals)), "largest": max(totals)},
        "judged": len(each),
    }


def page(result: dict[str, Any]) -> list[str]:
    """Lines of Markdown."""
    shown = []
    for vehicles, row in result["vehicles"].items():
        after, sent = row["after proposals"], row["bytes of a vehicle"]
        shown.append(
            [
                vehicles,
                *(f"{row['milliseconds'][step]:.1f}" for step in STEPS),
                f"**{after['median']:.0f}** ({after['largest']:.0f})",
                f"{sent['median']:,} ({sent['largest']:,})",
            ]
        )
    return [
        "# How long connected vehicles take",
        "",
        "Milliseconds of CPU time on one core that an instant takes, all vehicles together, medians"
        f" over {result['instants']} instants without an attack and with a ghost; made by"
        " `python benchmarks/connected.py`, shown by its `--page`. In brackets: the largest.",
        "",
        *markdown_table(
            ["vehicles", *STEPS, "after the proposals", "bytes that a vehicle sends"], shown
        ),
    ]


if __name__ == "__main__":
    main()
