"""What must be known of a run to judge its figures: what it was, and what it lacks."""

from __future__ import annotations

from dataclasses import asdict

from avsec_gym.report.run_facts import RunFacts
from avsec_gym.report.run_report import RunReport


def remarks(report: RunReport) -> list[str]:
    """Remarks that stand before everything else; none for a run that lacks nothing."""
    cells, result = report.facts.cells, []
    whole = cells.done + cells.failed + cells.missing
    if cells.missing:
        result.append(
            f"This run is not finished: {cells.missing:,} of {whole:,} cells are missing."
        )
    if cells.failed:
        result.append(
            f"{cells.failed:,} of {whole:,} cells failed; the end of this page lists the errors."
        )
    # Experiments of one run may have a remark in common.
    found = dict.fromkeys(remark for found in report.findings for remark in found.remarks)
    return [*result, *found]


def facts(run: RunFacts) -> list[tuple[str, str]]:
    """What was run, of what, by what."""
    manifest, cells = run.manifest, asdict(run.cells)
    asked = manifest["configuration"]
    given = {name: value for name, value in asked["options"].items() if value not in ("", None)}
    first = f", the first {asked['limit']:,}" if asked["limit"] else ""
    found = [
        ("experiments", ", ".join(manifest["experiments"])),
        ("scenarios", f"{asked['scenarios']}{first}"),
        ("seed", str(asked["seed"])),
        ("options", ", ".join(f"{name}={value}" for name, value in given.items()) or "none"),
        ("cells", ", ".join(f"{count:,} {status}" for status, count in cells.items())),
        ("begun", manifest["started"]),
        ("threads", f"{manifest['threads']} for each process"),
    ]
    sittings = manifest["sittings"]
    if sittings:
        last = sittings[-1]
        versions = {"Python": last["python"], **last["versions"]}
        found += [
            (
                "sittings",
                f"{len(sittings)}, the last one ended {last['ended'] or 'early, or never'}",
            ),
            ("workers", f"{last.get('workers', '–')} ({last.get('backend', '–')})"),
            ("machine", f"{last['platform']}, {last['processors']} processors"),
            ("versions", ", ".join(f"{name} {version}" for name, version in versions.items())),
            ("sources", ", ".join(dict.fromkeys(sitting["sources"] for sitting in sittings))),
        ]
    if wall := run.timings.wall:
        found.append(("took", f"{wall / 60:,.1f} minutes in sittings that were not cut short"))
    return found


def inputs(run: RunFacts) -> list[tuple[str, str]]:
    """Weights, patches and data: name, and SHA-256."""
    return [(name, source["sha256"]) for name, source in run.manifest["inputs"].items()]
