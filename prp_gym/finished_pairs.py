"""Pairs that are already evaluated, kept as files until the evaluation they belong to is complete."""

import hashlib
import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

import prp_gym
import prp_gym.baselines
import prp_gym.envs
from prp_gym.evaluation.results import list_versions, to_plain, write_json
from prp_gym.pairs import Pair, Record

_SOURCES = (prp_gym, prp_gym.envs, prp_gym.baselines)
_SUFFIXES = (".py", ".toml")


class FinishedPairs:
    """A folder with a file a pair, each with what its record depends on and with a checksum.

    A record is reused only by the code, the versions and the settings that made it.

    Args:
        folder: of the files; made with the first of them.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def find(self, pairs: Iterable[Pair]) -> tuple[dict[Pair, Record], list[Path]]:
        """Records that can be reused, and the files that cannot: of other settings or code, or damaged."""
        records, refused = {}, []
        for pair in pairs:
            path = self._path(pair)
            try:
                content = json.loads(path.read_bytes())
                if content != _content(pair, content["record"]):
                    raise ValueError(path)
                records[pair] = content["record"]
            except FileNotFoundError:
                continue
            except (OSError, ValueError, TypeError, LookupError, RecursionError):
                refused.append(path)
        return records, refused

    def keep(self, pair: Pair, record: Record) -> None:
        """Write a pair's file, whole or not at all.

        Raises:
            OutputError: the folder cannot be made or written to.
        """
        write_json(self._path(pair), _content(pair, record))

    def remove(self, pairs: Sequence[Pair]) -> None:
        """Remove the files of some pairs, and the folder if nothing else is in it."""
        for pair in pairs:
            path = self._path(pair)
            for own in (path, *self._folder.glob(f".{path.name}.*.part")):  # what a kill left half written
                if own.is_file():
                    own.unlink()
        if self._folder.is_dir() and not any(self._folder.iterdir()):
            self._folder.rmdir()

    def _path(self, pair: Pair) -> Path:
        return self._folder / f"{pair.name}.json"


def _content(pair: Pair, record: Record) -> dict[str, Any]:
    """What the file of a pair with this record holds."""
    key = {"pair": asdict(pair), "versions": list_versions(), "sources": source_digest()}
    text = json.dumps(record, sort_keys=True)
    plain: dict[str, Any] = to_plain(
        {"key": key, "checksum": hashlib.sha256(text.encode()).hexdigest(), "record": record}
    )
    return plain


@cache
def source_digest() -> str:
    """SHA-256 over the code and data files of this package, with their names."""
    digest = hashlib.sha256()
    for package in _SOURCES:
        folder = Path(str(package.__file__)).parent
        for path in sorted(folder.rglob("*")):
            if path.suffix in _SUFFIXES and path.is_file():
                name = f"{package.__name__}/{path.relative_to(folder).as_posix()}"
                digest.update(f"{name}\0{path.stat().st_size}\0".encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()
