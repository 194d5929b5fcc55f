"""Lists the studies, makes them anew, compares their sources with those of today.

``python -m studies.NAME`` is this command, too: see `studies.__init__`.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from avsec_gym.console import BAD_DATA, BAD_USAGE, DONE, print_line, print_table, say
from avsec_gym.errors import AvsecError, ConfigurationError, DataError
from avsec_gym.storage.text_files import write_text
from avsec_gym.suggestions import unknown_name
from studies.catalogue import STUDIES, minutes_of_command
from studies.index import called_current, outdated, pages
from studies.kept import keep
from studies.make_anew import Given, make_anew
from studies.provenance import read_records
from studies.source_states import SourceState, source_states
from studies.study import DATA, ROOT, Study


def main(arguments: Sequence[str]) -> int:
    """The command; its exit code."""
    parser = argparse.ArgumentParser("python -m studies", description="Makes pages of results.")
    parser.add_argument(
        "names",
        nargs="*",
        help="studies to make anew, or `check`, or `index`, or `keep` and studies",
    )
    for name, what in DATA.items():
        parser.add_argument(f"--{name}", nargs="+", metavar="DIR", default=[], help=what)
    parser.add_argument("--runs", default="runs", help="where runs lie (default: runs)")
    parser.add_argument("--json", action="store_true", help="list the studies as JSON")
    options = parser.parse_args(arguments)
    try:
        given = {name: [_place(folder) for folder in getattr(options, name)] for name in DATA}
        given["runs"] = [_place(options.runs)]
        match options.names:
            case []:
                _list(options.json)
            case ["check"]:
                _check()
            case ["index"]:
                _write()
            case ["keep", *names] if names:
                for study in map(_study, names):
                    print_line(f"{keep(study, ROOT / given['runs'][0]).relative_to(ROOT)} written")
            case names:
                for study in _asked(names, given):
                    make_anew(study, given)
                    _write()
    except AvsecError as error:
        say(f"studies: {error}")
        return BAD_USAGE if isinstance(error, ConfigurationError) else BAD_DATA
    return DONE


def _asked(names: Sequence[str], given: Given) -> list[Study]:
    """The studies of some names, each behind those that its page shows.

    Of these, what needs data that are not there stays as it is, and so does what is of today's
    sources.

    Raises:
        ConfigurationError: There is no such study, or data are not given.
    """
    found: list[Study] = []
    states: dict[str, SourceState] = {}
    for study in map(_study, names):
        name = study.name
        if lacking := [f"--{need} DIR ({DATA[need]})" for need in study.needs if not given[need]]:
            raise ConfigurationError(f"{name} needs {' and '.join(lacking)}")
        if study.shows and not states:  # All sources are read for them.
            states = source_states(read_records())
        for part in (STUDIES[part] for part in study.shows):
            if lacking := [f"--{need}" for need in part.needs if not given[need]]:
                say(f"{part.name} stays as it is: it needs {' and '.join(lacking)}")
            elif states[part.name].stale is False:
                say(f"{part.name} stays as it is: its sources are unchanged since it was made")
            else:
                found.append(part)
        found.append(study)
    return list(dict.fromkeys(found))


def _study(name: str) -> Study:
    """The study of a name.

    Raises:
        ConfigurationError: There is none.
    """
    if name not in STUDIES:
        raise ConfigurationError(unknown_name(f"there is no study {name!r}", name, STUDIES))
    return STUDIES[name]


def _place(path: str) -> str:
    """As seen from the checkout, in which steps are taken."""
    place = Path(path).resolve()
    return str(place.relative_to(ROOT) if place.is_relative_to(ROOT) else place)


def _list(as_json: bool) -> None:
    states = source_states(read_records())
    if as_json:
        print_line(
            json.dumps([_facts(study, states[study.name]) for study in STUDIES.values()], indent=1)
        )
        return
    rows = [
        [
            study.name,
            study.question,
            f"{minutes_of_command(study)} min",
            states[study.name].word,
            study.command,
        ]
        for study in STUDIES.values()
    ]
    print_table("Studies", ["study", "question", "takes about", "sources", "command"], rows)


def _facts(study: Study, state: SourceState) -> dict[str, object]:
    return {
        "name": study.name,
        "question": study.question,
        "command": study.command,
        "minutes": minutes_of_command(study),
        "writes": study.writes,
        "stale": state.stale,
        "sources": state.text,
    }


def _check() -> None:
    """Tell what is stale, which is no fault; a page that calls itself current all the same is one.

    Raises:
        DataError: A page states that its sources are unchanged, and they are not.
    """
    from studies.docs_pages import docs_called_current, docs_pages

    states = source_states(read_records())
    kinds = [state.stale for state in states.values()]
    print_line(
        f"studies: {kinds.count(False)} of unchanged sources, {kinds.count(True)} stale,"
        f" {kinds.count(None)} not made yet"
    )
    written = pages(states) | docs_pages(states)
    if others := [path.relative_to(ROOT).as_posix() for path in outdated(written)]:
        print_line(f"`python -m studies index` would say so in {', '.join(others)}")
    if wrong := called_current(states) + docs_called_current(states):
        raise DataError(
            f"{', '.join(wrong)}: sources are called unchanged that have changed.",
            remedy="Run `python -m studies index`, which makes the pages state so.",
        )


def _write() -> None:
    # Pages bring in whatever they are made from, which a study begins without.
    from studies.docs_pages import docs_pages

    states = source_states(read_records())
    written = pages(states) | docs_pages(states)
    for path in outdated(written):
        write_text(path, written[path], overwrite=True)
        print_line(f"{path.relative_to(ROOT)} written")


if __name__ == "__main__":
    asked = (__spec__.name if __spec__ else "").removesuffix(".__main__").partition(".")[2]
    sys.exit(main([*([asked] if asked else []), *sys.argv[1:]]))
