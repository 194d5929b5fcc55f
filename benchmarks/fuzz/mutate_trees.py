"""What happens to JSON and XML: values of other types, keys lost, depth without end, entities."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from random import Random
from typing import Any

from mutate_bytes import Mutator
from mutate_text import NUMBERS

_VALUES: tuple[Any, ...] = (
    None, True, False, 0, -1, 1.5, 10**30, -(10**400), float("nan"), float("inf"), float("-inf"),
    "", "nan", "x" * 10_000, "\ud800", "../..", [], {}, [[]], [None], {"": {}}, [1, "2", None],
)  # fmt: skip


def value(content: bytes, random: Random) -> bytes:
    """A value becomes one of another type."""
    tree = json.loads(content)
    holder, key = _place(tree, random)
    if holder is None:
        return json.dumps(random.choice(_VALUES)).encode()
    holder[key] = random.choice(_VALUES)
    return json.dumps(tree).encode("utf-8", "surrogatepass")


def key(content: bytes, random: Random) -> bytes:
    """A key or an element is missing, renamed or surplus."""
    tree = json.loads(content)
    holder, name = _place(tree, random)
    if holder is None:
        return b"[]"
    match random.randrange(3):
        case 0:
            del holder[name]
        case 1 if isinstance(holder, dict):
            holder[random.choice(("", "__class__", str(name).upper(), "x" * 500))] = holder.pop(
                name
            )
        case _ if isinstance(holder, dict):
            holder["surplus"] = random.choice(_VALUES)
        case _:
            holder.append(random.choice(_VALUES))
    return json.dumps(tree).encode("utf-8", "surrogatepass")


def exchanged(content: bytes, random: Random) -> bytes:
    """Two values change places."""
    tree = json.loads(content)
    (one, name), (other, its_name) = _place(tree, random), _place(tree, random)
    if one is None or other is None:
        return b"{}"
    one[name], other[its_name] = other[its_name], one[name]
    try:
        return json.dumps(tree).encode("utf-8", "surrogatepass")
    except ValueError:  # A value that now holds itself.
        return b"{}"


def deep(content: bytes, random: Random) -> bytes:
    """A value is nested without end."""
    depth = random.choice((100, 990, 5_000, 200_000))
    opening, closing = random.choice((("[", "]"), ('{"a":', "}")))
    nest = opening * depth + "1" + closing * depth
    text = content.decode()
    places = [m.end() for m in re.finditer(r":\s*", text)] or [0]
    place = random.choice(places)
    return (text[:place] + nest + "," + text[place:]).encode() if place else nest.encode()


def doubled_key(content: bytes, random: Random) -> bytes:
    """A key stands twice, the second time with something else."""
    text = content.decode()
    keys = re.findall(r'"[^"\\]*"(?=\s*:)', text)
    if not keys:
        return content
    addition = f"{random.choice(keys)}: {json.dumps(random.choice(_VALUES[:9]))}, "
    place = text.find("{") + 1
    end = text.rfind("}")
    return (
        (text[:place] + addition + text[place:])
        if random.random() < 0.5
        else (text[:end] + ", " + addition.rstrip(", ") + text[end:])
    ).encode()


JSON: dict[str, Mutator] = {
    f"json_{mutator.__name__}": mutator for mutator in (value, key, exchanged, deep, doubled_key)
}


def element(content: bytes, random: Random) -> bytes:
    """A leaf element is missing, doubled, empty, renamed, or wrapped in another."""
    text = content.decode("utf-8", "replace")
    places = list(re.finditer(r"<(\w+)[^<>]*>[^<>]*</\1>", text))
    if not places:
        return content
    place = random.choice(places)
    whole, name = place.group(), place.group(1)
    new = random.choice(
        ("", whole * 2, f"<{name}/>", whole.replace(name, "other"), f"<{name}>{whole}</{name}>")
    )
    return (text[: place.start()] + new + text[place.end() :]).encode()


def big_element(content: bytes, random: Random) -> bytes:
    """An element with children is missing or comes many times."""
    text = content.decode("utf-8", "replace")
    places = list(re.finditer(r"<(\w+)[^<>/]*>(?:(?!<\1[ >]).)*?</\1>", text, re.S))
    if not places:
        return content
    place = random.choice(places)
    new = place.group() * random.choice((0, 2, 50))
    return (text[: place.start()] + new + text[place.end() :]).encode()


def strange_element(content: bytes, random: Random) -> bytes:
    """An element and all in it come under a name that the format does not know, or hardly."""
    text = content.decode("utf-8", "replace")
    names = sorted(set(re.findall(r"</(\w+)>", text)))
    if not names:
        return content
    name = random.choice(names)
    new = random.choice((name + "s", name.capitalize(), name[:-1], f"a_{name}", *names))
    count = random.choice((0, 2))  # All of that name, or one that has no other of it within.
    return re.sub(rf"(</?){name}(?=[\s>/])", rf"\g<1>{new}", text, count=count).encode()


def second_element(content: bytes, random: Random) -> bytes:
    """A second element of a name, with other numbers, before or behind the first."""
    text = content.decode("utf-8", "replace")
    names = sorted(set(re.findall(r"</(\w+)>", text)))
    if not names:
        return content
    name = random.choice(names)
    places = list(re.finditer(rf"<{name}[\s>](?:(?!<{name}[\s>]).)*?</{name}>", text, re.S))
    if not places:
        return content
    place = random.choice(places)
    other = re.sub(r"-?\d+\.?\d*(?=<)", lambda _: str(random.randint(0, 90)), place.group())
    pair = random.choice((place.group() + other, other + place.group()))
    return (text[: place.start()] + pair + text[place.end() :]).encode()


def mixed(content: bytes, random: Random) -> bytes:
    """Text among elements, or an element among text."""
    text = content.decode("utf-8", "replace")
    places = [m.end() for m in re.finditer(">", text)]
    if not places:
        return content
    place = random.choice(places)
    new = random.choice(("7", "text", "<b>1</b>", "<x>3</x>", "<!-- 7 -->"))
    return (text[:place] + new + text[place:]).encode()


def attribute(content: bytes, random: Random) -> bytes:
    """An attribute is missing, or holds something else."""
    text = content.decode("utf-8", "replace")
    places = list(re.finditer(r'\s(\w+)="[^"]*"', text))
    if not places:
        return content
    place = random.choice(places)
    new = random.choice(("", f' {place.group(1)}="{random.choice(NUMBERS)}"', ' other="1"'))
    return (text[: place.start()] + new + text[place.end() :]).encode()


def text_of_element(content: bytes, random: Random) -> bytes:
    """The text between two tags becomes a strange number or word."""
    text = content.decode("utf-8", "replace")
    # Blank or not is asked afterwards: the pattern would ask it of each character of a long text.
    places = [found for found in re.finditer(r">([^<>]+)<", text) if found.group(1).strip()]
    if not places:
        return content
    place = random.choice(places)
    new = random.choice((*NUMBERS, "<![CDATA[5]]>", "&#x35;", "5<!-- -->6", "<b>5</b>"))
    return (text[: place.start(1)] + new + text[place.end(1) :]).encode()


def entities(content: bytes, random: Random) -> bytes:
    """Entities that unfold, fetch a file, or ask for a document type elsewhere."""
    bomb = '<!ENTITY a "aaaaaaaaaa">' + "".join(
        f'<!ENTITY {chr(98 + i)} "{f"&{chr(97 + i)};" * 10}">' for i in range(9)
    )
    declaration, use = random.choice(
        (
            (f"<!DOCTYPE x [{bomb}]>", "&j;"),
            ('<!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/hostname">]>', "&e;"),
            ('<!DOCTYPE x SYSTEM "file:///etc/hostname">', "7"),
            ('<!DOCTYPE x [<!ENTITY % p SYSTEM "file:///etc/hostname"> %p;]>', "7"),
            ('<!DOCTYPE x [<!ENTITY e "7">]>', "&e;"),
            ('<!DOCTYPE x [<!ATTLIST x y CDATA "z">]>', "7"),
        )
    )
    text = content.decode("utf-8", "replace")
    start = text.find("?>") + 2 if text.lstrip().startswith("<?xml") else 0
    text = re.sub(r"<!DOCTYPE[^>]*>", "", text)
    body = re.sub(r">([^<>\s]+)<", f">{use}<", text[start:], count=1)
    return (text[:start] + declaration + body).encode()


def nested(content: bytes, random: Random) -> bytes:
    """Elements in elements without end."""
    depth = random.choice((20, 1_000, 50_000))
    text = content.decode("utf-8", "replace")
    place = random.choice([m.end() for m in re.finditer(">", text)] or [0])
    return (text[:place] + "<d>" * depth + "</d>" * depth + text[place:]).encode()


def declaration(content: bytes, random: Random) -> bytes:
    """Another version or encoding is declared."""
    text = content.decode("utf-8", "replace")
    new = random.choice(
        (
            '<?xml version="1.0" encoding="utf-16"?>',
            '<?xml version="1.0" encoding="latin-1"?>',
            '<?xml version="1.0" encoding="ebcdic-cp-us"?>',
            '<?xml version="9.0"?>',
            '<?xml version="1.0" encoding="UTF-7"?>',
        )
    )
    return re.sub(r"<\?xml[^>]*\?>", new, text, count=1).encode()


XML: dict[str, Mutator] = {
    f"xml_{mutator.__name__}": mutator
    for mutator in (
        element,
        big_element,
        strange_element,
        second_element,
        mixed,
        attribute,
        text_of_element,
        entities,
        nested,
        declaration,
    )
}


def _place(tree: Any, random: Random) -> tuple[Any, Any]:
    places = list(_places(tree))
    return random.choice(places) if places else (None, None)


def _places(tree: Any) -> Iterator[tuple[Any, Any]]:
    names = range(len(tree)) if isinstance(tree, list) else tree if isinstance(tree, dict) else ()
    for name in names:
        yield tree, name
        yield from _places(tree[name])
