"""Damage to files: bytes that are changed, lost or added, drawn from a seed."""

from collections.abc import Iterator

import numpy as np


def damaged(content: bytes, count: int, seed: int = 0) -> Iterator[bytes]:
    """The content with one bit flipped, one byte replaced, the end cut off, or something inserted.

    Args:
        content: content of a file.
        count: number of damaged contents.
        seed: seed of the positions.
    """
    rng = np.random.default_rng(seed)
    for index in range(count):
        position = int(rng.integers(len(content)))
        before, after = content[:position], content[position + 1 :]
        byte = content[position]
        yield (
            before + bytes([byte ^ 1 << int(rng.integers(8))]) + after,
            before + bytes([int(rng.integers(256))]) + after,
            before,
            before + rng.bytes(3) + content[position:],
            before + after,
        )[index % 5]
