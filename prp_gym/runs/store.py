"""Pairs that are already evaluated, kept as files until the evaluation they belong to is complete."""

import hashlib
import json
import os
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeVar

from prp_gym.evaluation.results import to_plain, write_json
from prp_gym.runs.job import Job, Record, running_code

JobT = TypeVar("JobT", bound=Job)


class JobStore:
    """A folder with a file a pair, each with what its record depends on and with a checksum.

    A record is reused only by the code, the versions and the settings that made it. Several runs may have
    the same folder.

    Args:
        folder: of the files; made with the first of them.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def find(self, pairs: Iterable[JobT]) -> tuple[dict[JobT, Record], list[Path]]:
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

    def keep(self, pair: Job, record: Record) -> None:
        """Write a pair's file, whole or not at all.

        Raises:
            OutputError: the folder cannot be made or written to.
        """
        write_json(self._path(pair), _content(pair, record))

    def remove(self, pairs: Sequence[Job]) -> None:
        """Remove the files of some pairs, and the folder if nothing else is in it."""
        for pair in pairs:
            path = self._path(pair)
            parts = self._folder.glob(f".{path.name}.*.part")
            for own in (path, *(part for part in parts if _is_left_behind(part))):
                if own.is_file():
                    own.unlink(missing_ok=True)  # another run may have removed it just now
        with suppress(OSError):  # not empty, or not there
            self._folder.rmdir()

    def _path(self, pair: Job) -> Path:
        return self._folder / f"{pair.name}.json"


def _content(pair: Job, record: Record) -> dict[str, Any]:
    """What the file of a pair with this record holds."""
    key = {"pair": asdict(pair), "code": running_code()}
    text = json.dumps(record, sort_keys=True)
    plain: dict[str, Any] = to_plain(
        {"key": key, "checksum": hashlib.sha256(text.encode()).hexdigest(), "record": record}
    )
    return plain


def _is_left_behind(part: Path) -> bool:
    """Whether nobody writes a half written file any more: its process is this one, or is not alive."""
    process = part.suffixes[-2].removeprefix(".")
    if not process.isdecimal():
        return False
    try:
        if int(process) != os.getpid():
            os.kill(int(process), 0)  # asks only
            return False
    except ProcessLookupError:
        return True
    except PermissionError:  # alive, and somebody else's
        return False
    return True
