"""`ResultFolder`: the folder of one run of a command, which no later run overwrites."""

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from prp_gym.artifacts import to_plain, write_file, write_json
from prp_gym.errors import DataFileError, InvalidValueError, OutputError
from prp_gym.files.checksum import checksum
from prp_gym.files.file_reader import FileReader
from prp_gym.processes.leftovers import part_of

RESULTS_FOLDER = Path("results")
"""Folder of all results, below the current one."""

LATEST = "latest"
"""Link to the folder of the latest run of a command; a small text file where links are not possible."""

RECORD = "run.json"
"""File in a run's folder that says which run it is, and whether it is finished."""

_STAMP = "%Y-%m-%d_%H-%M-%S"
_NAME = re.compile(r"[\w.-]{1,80}")
_MOST_IN_A_SECOND = 1000


@dataclass(frozen=True)
class ResultFolder:
    """The folder into which a run of a command writes.

    Attributes:
        path: path of the folder.
        command: name of the command; empty for a folder that the user has named, which holds no record.
        key: digest of everything that the results depend on; the same command with the same key goes on
            with an unfinished run.
    """

    path: Path
    command: str = ""
    key: str = ""

    @classmethod
    def choose(
        cls, command: str, output: Path | None, name: str, content: Any, goes_on: bool
    ) -> "ResultFolder":
        """The folder that the user names, that of an unfinished run with the same content, or a new one.

        Args:
            command: name of the command.
            output: folder that the user names, used exactly as it is; None to choose one below `results`.
            name: what the user adds to the name of a new folder; empty for nothing.
            content: everything that the results depend on, as `to_plain` takes it.
            goes_on: whether an unfinished run goes on; otherwise the folder is always a new one.

        Returns:
            the folder; a new one is made, empty.

        Raises:
            InvalidValueError: a name that cannot be part of a folder's name, or one beside `output`.
            OutputError: a folder that cannot be made.
        """
        _check_name(name, output)
        if output is not None:
            return cls(output)
        parent, key = RESULTS_FOLDER / command, checksum(to_plain([command, name, content]))
        found = _unfinished(parent, key) if goes_on else None
        return cls(found or _make(parent, name), command, key)

    @contextmanager
    def in_use(self) -> Iterator[None]:
        """Record the run in its folder, point `latest` at it, and record its end unless it fails.

        Raises:
            OutputError: the folder cannot be written to.
        """
        if not self.command:
            yield
            return
        self._write(finished=False)
        point_latest(self.path)
        yield
        self._write(finished=True)

    def _write(self, finished: bool) -> None:
        write_json(self.path / RECORD, {"command": self.command, "key": self.key, "finished": finished})


def _check_name(name: str, output: Path | None) -> None:
    if name and output is not None:
        raise InvalidValueError("--name", name, "only without --output, which names the whole folder")
    if name and not _NAME.fullmatch(name):
        raise InvalidValueError("--name", name, "up to 80 letters, digits, dots, hyphens and underscores")


def _unfinished(parent: Path, key: str) -> Path | None:
    """The newest folder of an unfinished run with a key; None without one."""
    for record in sorted(parent.glob(f"*/{RECORD}"), reverse=True):
        folder = record.parent
        if not folder.is_symlink() and _read(record) == {"key": key, "finished": False}:
            return folder
    return None


def _read(record: Path) -> dict[str, Any]:
    """Key and end of a run; nothing of a damaged record."""
    try:
        content = FileReader().read_json(record)
    except DataFileError:
        return {}
    return {name: content.get(name) for name in ("key", "finished")} if isinstance(content, dict) else {}


def _make(parent: Path, name: str) -> Path:
    """A new folder whose name begins with the time of the day."""
    stamp = datetime.now().strftime(_STAMP)  # in local time, as clocks on the wall show it
    ending = f"_{name}" if name else ""
    for number in range(1, _MOST_IN_A_SECOND):
        folder = parent / f"{stamp}{f'_{number}' if number > 1 else ''}{ending}"
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            continue  # of a run that began in the same second
        except OSError as error:
            raise OutputError(folder, error) from error
        return folder
    raise OutputError(parent, f"{_MOST_IN_A_SECOND} runs began in the same second")


def point_latest(folder: Path) -> None:
    """Make `latest` beside a folder lead to it, at once for every reader.

    Args:
        folder: folder of a run.

    Raises:
        OutputError: neither a link nor a file of that name can be written.
    """
    latest = folder.parent / LATEST
    part = part_of(latest)
    try:
        os.symlink(folder.name, part, target_is_directory=True)
        os.replace(part, latest)
    except (OSError, NotImplementedError):  # a file system without links
        with suppress(OSError):
            part.unlink()
        write_file(latest, f"{folder.name}\n".encode())


def latest_folder(command: str) -> Path:
    """The folder of the latest run of a command below `results`, through the link or the text file.

    Args:
        command: name of the command.

    Returns:
        the folder, or `latest` itself where there is no run yet.
    """
    latest = RESULTS_FOLDER / command / LATEST
    if not latest.is_file():
        return latest
    return latest.parent / Path(FileReader().read_text(latest).strip()).name
