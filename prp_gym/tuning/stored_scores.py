"""`StoredScores`: scores of the validation of a search, kept in a file that outlives a killed run."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from prp_gym.artifacts import write_json
from prp_gym.errors import DataFileError
from prp_gym.files.checksum import checksum, seal, unseal
from prp_gym.files.file_reader import RECORD_SIZE, FileReader
from prp_gym.tuning.objective import EpisodeRows

VALIDATION = "validation.json"
_REMEDY = "Remove it to validate anew"


class StoredScores:
    """Scores of episodes by name, written whenever there is a new one; those of another search are not used.

    One run at a time may use a folder, which its user locks with `FolderLock`.

    Args:
        folder: folder of the file, which exists.
        key: everything that the scores depend on, as plain JSON.

    Raises:
        DataFileError: a file that is damaged or altered; it is left as it is.
    """

    def __init__(self, folder: Path, key: Mapping[str, Any]) -> None:
        self._path, self._search = folder / VALIDATION, checksum(dict(key))
        self._scores = self._read() if self._path.exists() else {}

    def find(
        self, names: Sequence[str], compute: Callable[[Sequence[str]], Sequence[EpisodeRows]]
    ) -> list[EpisodeRows]:
        """The scores of these names; those that are not there are computed together, and kept.

        Raises:
            OutputError: the folder was removed, or cannot be written to.
        """
        missing = [name for name in names if name not in self._scores]
        if missing:
            self._scores |= dict(zip(missing, compute(missing), strict=True))
            write_json(self._path, seal({"search": self._search, "scores": self._scores}))
        return [self._scores[name] for name in names]

    def _read(self) -> dict[str, EpisodeRows]:
        content = unseal(self._path, FileReader(RECORD_SIZE).read_json(self._path))
        scores = content.get("scores")
        if not isinstance(scores, dict) or not all(_are_rows(rows) for rows in scores.values()):
            raise DataFileError(self._path, "holds no scores of episodes by name", _REMEDY)
        return scores if content.get("search") == self._search else {}


def _are_rows(value: Any) -> bool:
    """Whether a value of JSON holds scores by scenario and episode, at least one of each."""
    rows = value if isinstance(value, list) else []
    filled = [isinstance(own, list) and bool(own) for own in rows]
    return bool(filled) and all(filled) and all(type(item) is float for own in rows for item in own)
