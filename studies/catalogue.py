"""Every study, from catalogue.toml: each file in studies/results belongs to one of them.

A study of the catalogue has its ``question``; ``minutes`` that its commands take, about, on two
cores, with nothing left of an earlier time; the files that it ``writes``, below studies/results or
in docs, of which a stale study may lack the JSON that its commands write since; ``commands``, one a
line.  Its sources are what the commands run and import; ``networks`` and ``also`` are those that
are named by strings.  ``shows`` names studies whose results its page shows, too, and
``explained`` pages of docs that are written by hand about them.
"""

from __future__ import annotations

import shlex
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from avsec_gym.cli import COMMANDS
from avsec_gym.runs.catalogue import EXPERIMENTS
from studies.study import RESULTS, ROOT, Step, Study

_SHORT = {
    "$page": "avsec report $runs/$name --markdown $results/$name.md --overwrite --json"
    " > $results/$name.json",
    "$judged": "--seed 2 --threads 1 --retry --out $runs/$name",
    "$given": "--scenarios $scenarios --threads 1"
    " --options frames=$runs/twins/street,$runs/twins/highway",
    "$driven": "--settings truth blind error-model --error-model stereo_rcnn stereo_rcnn_patch"
    " stereo_rcnn_thesis_pgd dsgn dsgn_patch dsgn_thesis_pgd --pictures 0 --jobs 2 --resume",
    "$guarded": '$sensing, "response": "stop", "handover": 2, "validator": {"name": "thresholds",'
    ' "thresholds": "avsec_gym/validation/fits/kitti_lidar_3_2.thresholds.json"}',
    "$sensing": '"perception": "sensors", "detector": "stereo_rcnn"',
    "$convert": "python -c 'import cv2, sys; cv2.imwrite(sys.argv[2], cv2.imread(sys.argv[1]))'",
    "$print": "python -c 'import sys; sys.stdout.write(open(sys.argv[1]).read())'",
    "$remove": "python -c 'import shutil, sys; shutil.rmtree(sys.argv[1], ignore_errors=True)'",
    "$results": RESULTS,
}
"""What the commands of several studies have in common."""


def read_catalogue(path: Path = Path(__file__).with_name("catalogue.toml")) -> dict[str, Study]:
    """The studies by their names, in the order of the file."""
    return {name: _study(name, facts) for name, facts in tomllib.loads(path.read_text()).items()}


def _study(name: str, facts: dict[str, Any]) -> Study:
    commands = facts["commands"].replace("\\\n", " ")
    for short, long in _SHORT.items():
        commands = commands.replace(short, long)
    steps = [_step(line) for line in commands.replace("$name", name).splitlines() if line.strip()]
    networks = facts.get("networks", "").split()
    folders = [f"avsec_gym/perception/detectors/{network}" for network in networks]
    sources = [
        *(source for step in steps for source in _sources(step)),
        *(folder for folder in folders if (ROOT / folder).is_dir()),
        *(f"avsec_gym/perception/weights/{network}_small.safetensors" for network in networks),
        *facts.get("also", "").split(),
    ]
    writes = facts["writes"].split()
    return Study(
        name=name,
        question=facts["question"],
        minutes=facts["minutes"],
        writes=tuple(path if path.startswith("docs/") else f"{RESULTS}/{path}" for path in writes),
        steps=tuple(steps),
        sources=tuple(dict.fromkeys(sources)),
        shows=tuple(facts.get("shows", "").split()),
        explained=tuple(facts.get("explained", "").split()),
    )


def _step(line: str) -> Step:
    """Of ``python WORDS``, ``avsec WORDS``, either with ``> FILE`` behind it."""
    program, *words = shlex.split(line)
    to = ""
    if words[-2:-1] == [">"]:
        *words, _, to = words
    return Step(tuple(words) if program == "python" else ("-m", "avsec_gym", *words), to)


def _sources(step: Step) -> list[str]:
    """The files that it runs; of ``avsec run``, those of the experiments as well."""
    match step.words:
        case ("-m", "avsec_gym", *words):
            named = [EXPERIMENTS[word] for word in words[1:] if word in EXPERIMENTS]
            places = [_place_of_command(words), *(named if words[0] == "run" else [])]
            return [_path(place.partition(":")[0]) for place in places]
        case ("-c", *_):
            return []
        case ("-m", module, *_):
            return [_path(module)]
    return [step.words[0]]


def _place_of_command(words: Sequence[str]) -> str:
    """``"module:class"`` of the command that ``avsec WORDS`` begins with."""
    found = COMMANDS[words[0]]
    return found if isinstance(found, str) else found.commands[words[1]]


def _path(module: str) -> str:
    return module.replace(".", "/") + ".py"


STUDIES = read_catalogue()
"""Studies by their names."""


def minutes_of_command(study: Study) -> int:
    """What `Study.command` takes, about: it makes the parts that the page shows, too.

    A part stays as it is where it needs data that the command does not name, and takes nothing.
    """
    parts = [part for name in study.shows if {*(part := STUDIES[name]).needs} <= {*study.needs}]
    return sum(each.minutes for each in (study, *parts))
