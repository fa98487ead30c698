"""Records of finished jobs, kept as files until the run to which they belong is complete."""

from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from prp_gym.artifacts import write_json
from prp_gym.files.checksum import seal
from prp_gym.files.file_reader import RECORD_SIZE, FileReader
from prp_gym.processes.leftovers import remove_leftovers
from prp_gym.runs.code import running_code
from prp_gym.runs.job import Job, Record
from prp_gym.runs.key import key_of

JobT = TypeVar("JobT", bound=Job)


class JobStore:
    """A folder with one file for each job, with what its record depends on and a checksum.

    A record is reused only by the code, the versions and the settings that made it. Several runs may have
    the same folder.

    Args:
        folder: folder of the files, which is made with the first file.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def find(self, jobs: Iterable[JobT]) -> tuple[dict[JobT, Record], list[Path]]:
        """Records that can be reused, and the files that cannot: of other settings or code, or damaged."""
        records, refused = {}, []
        for job in jobs:
            path = self._path(job)
            if not path.exists():
                continue
            try:
                content = FileReader(RECORD_SIZE).read_json(path)
                if content != _content(job, content["record"]):
                    raise ValueError(path)
                records[job] = content["record"]
            except (ValueError, TypeError, LookupError):
                refused.append(path)
        return records, refused

    def keep(self, job: Job, record: Record) -> None:
        """Write a job's file, whole or not at all.

        Raises:
            OutputError: the folder cannot be made or written to.
        """
        write_json(self._path(job), _content(job, record))

    def remove(self, jobs: Sequence[Job]) -> None:
        """Remove the files of some jobs, what ended processes have left, and the folder if it is empty."""
        remove_leftovers(self._folder)
        for job in jobs:
            path = self._path(job)
            if path.is_file():
                path.unlink(missing_ok=True)  # another run may have removed it just now
        with suppress(OSError):  # not empty, or not there
            self._folder.rmdir()

    def _path(self, job: Job) -> Path:
        return self._folder / f"{job.name}.json"


def _content(job: Job, record: Record) -> dict[str, Any]:
    """What the file of a job with this record holds."""
    key = {"job": key_of(job), "code": running_code()}
    return seal({"key": key, "record": record})
