"""What happens to any file: bits flip, ends are cut off, blocks go missing, move or come twice."""

from __future__ import annotations

import gzip
from collections.abc import Callable
from random import Random

Mutator = Callable[[bytes, Random], bytes]


def flip_bits(content: bytes, random: Random) -> bytes:
    """One to sixteen bits."""
    changed = bytearray(content)
    for _ in range(random.choice((1, 2, 4, 16))):
        if changed:
            changed[random.randrange(len(changed))] ^= 1 << random.randrange(8)
    return bytes(changed)


def overwrite(content: bytes, random: Random) -> bytes:
    """A block of random, equal or extreme bytes."""
    start, end = _block(content, random)
    filler = random.choice(
        (random.randbytes(end - start), b"\0" * (end - start), b"\xff" * (end - start))
    )
    return content[:start] + filler + content[end:]


def insert(content: bytes, random: Random) -> bytes:
    """A block that was not there."""
    place = random.randint(0, len(content))
    return content[:place] + random.randbytes(random.choice((1, 3, 17, 512))) + content[place:]


def remove(content: bytes, random: Random) -> bytes:
    """A block is missing."""
    start, end = _block(content, random)
    return content[:start] + content[end:]


def double(content: bytes, random: Random) -> bytes:
    """A block comes twice."""
    start, end = _block(content, random)
    return content[:end] + content[start:]


def swap(content: bytes, random: Random) -> bytes:
    """Two neighbouring blocks change places."""
    cuts = sorted(random.randint(0, len(content)) for _ in range(3))
    a, b, c = cuts
    return content[:a] + content[b:c] + content[a:b] + content[c:]


def cut_off(content: bytes, random: Random) -> bytes:
    """The end is missing, as of a download that broke off."""
    return content[: random.randrange(len(content))] if content else content


def cut_off_in_front(content: bytes, random: Random) -> bytes:
    """The beginning is missing."""
    return content[random.randrange(len(content)) :] if content else content


def zero_tail(content: bytes, random: Random) -> bytes:
    """The length is right and the end was never written, as after a power failure."""
    place = random.randint(0, len(content))
    return content[:place] + b"\0" * (len(content) - place)


def append_itself(content: bytes, random: Random) -> bytes:
    """Written twice."""
    return content * random.choice((2, 3))


def compress(content: bytes, _: Random) -> bytes:
    """Still in its gzip."""
    return gzip.compress(content, 1)


def extreme_word(content: bytes, random: Random) -> bytes:
    """Four or eight bytes become a number at the edge of its type, or one that is none."""
    word = random.choice(
        (
            b"\xff\xff\xff\x7f",
            b"\x00\x00\x00\x80",
            b"\xff\xff\xff\xff",
            b"\x00\x00\xc0\x7f",  # NaN, float32
            b"\x00\x00\x80\x7f",  # infinity
            b"\xff\xff\x7f\x7f",  # the largest float32
            b"\x00\x00\x00\x00\x00\x00\xf8\x7f",  # NaN, float64
            b"\xff\xff\xff\xff\xff\xff\xff\x7f",
        )
    )
    if random.random() < 0.5:
        word = word[::-1]
    place = random.randint(0, max(0, len(content) - len(word))) // 4 * 4
    return content[:place] + word + content[place + len(word) :]


BYTES: dict[str, Mutator] = {
    mutator.__name__: mutator
    for mutator in (
        flip_bits,
        overwrite,
        insert,
        remove,
        double,
        swap,
        cut_off,
        cut_off_in_front,
        zero_tail,
        append_itself,
        compress,
        extreme_word,
    )
}


def _block(content: bytes, random: Random) -> tuple[int, int]:
    start = random.randint(0, len(content))
    return start, min(len(content), start + random.choice((1, 4, 64, 1024)))
