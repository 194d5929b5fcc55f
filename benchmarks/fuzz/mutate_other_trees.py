"""The changes of JSON's trees in files that hold such trees otherwise: a line each, or as YAML."""

from __future__ import annotations

import json
from random import Random

from mutate_bytes import Mutator
from mutate_trees import JSON


def _of_a_line(mutate: Mutator) -> Mutator:
    """One of the lines is changed as a tree."""

    def mutate_line(content: bytes, random: Random) -> bytes:
        lines = content.splitlines(keepends=True)
        at = random.randrange(len(lines))
        lines[at] = mutate(lines[at].rstrip(b"\n"), random).replace(b"\n", b" ") + b"\n"
        return b"".join(lines)

    return mutate_line


def _of_yaml(mutate: Mutator) -> Mutator:
    """The whole file is changed as a tree; YAML reads JSON, too."""

    def mutate_yaml(content: bytes, random: Random) -> bytes:
        import yaml

        changed = mutate(json.dumps(yaml.safe_load(content)).encode(), random)
        if random.random() < 0.3:
            return changed
        try:
            return yaml.safe_dump(json.loads(changed), sort_keys=False).encode()
        except (yaml.YAMLError, ValueError, RecursionError):
            return changed

    return mutate_yaml


JSON_LINES: dict[str, Mutator] = {f"line_{name}": _of_a_line(each) for name, each in JSON.items()}
YAML: dict[str, Mutator] = {f"yaml_{name}": _of_yaml(each) for name, each in JSON.items()}
