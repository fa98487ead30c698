"""`RunFolder`: the files of a training run, and whether it is finished or may be resumed."""

import hashlib
import os
import shutil
from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

from prp_gym.agents.sb3.packages import require
from prp_gym.agents.training.recipes import Recipe
from prp_gym.agents.training.run_records import RunCurve, RunFacts, RunResult
from prp_gym.artifacts import list_versions, prepare_folder, to_plain, write_file, write_json
from prp_gym.errors import DataFileError, InvalidValueError, RunFolderError, shortened
from prp_gym.files.checksum import seal, unseal_or_former
from prp_gym.files.file_reader import RECORD_SIZE, FileReader
from prp_gym.files.typed_reader import TypedReader
from prp_gym.processes.folder_lock import LOCK, FolderLock

_RESERVED = ".command.lock"
_LOCKS = frozenset((LOCK, _RESERVED))
_PACKAGES = ("stable-baselines3", "sb3-contrib", "torch")
_RECORDS, _SETTINGS = FileReader(RECORD_SIZE), FileReader()

ContentT = TypeVar("ContentT")


@dataclass(frozen=True)
class RunFolder:
    """The folder of one training seed.

    Attributes:
        path: path of the folder.
    """

    path: Path

    @property
    def config(self) -> Path:
        """Path of the merged recipe."""
        return self.path / "config.yml"

    @property
    def run(self) -> Path:
        """Path of the file with command, versions, seed, and settings other than the recipe."""
        return self.path / "run.json"

    @property
    def curve(self) -> Path:
        """Path of the learning curve: the evaluations during training."""
        return self.path / "curve.json"

    @property
    def progress(self) -> Path:
        """Path of the progress file: the number of steps trained so far, for progress bars."""
        return self.path / "progress.json"

    @property
    def result(self) -> Path:
        """Path of the result, which exists once training is finished."""
        return self.path / "result.json"

    @property
    def agent(self) -> Path:
        """Path of the exported best policy, without suffix."""
        return self.path / "agent"

    @property
    def tensorboard(self) -> Path:
        """Path of the folder for TensorBoard's files."""
        return self.path / "tensorboard"

    @property
    def is_finished(self) -> bool:
        """Whether the training is complete."""
        return os.path.exists(self.result)

    @property
    def is_begun(self) -> bool:
        """Whether the folder holds a run."""
        return os.path.exists(self.config)

    def read_result(self) -> dict[str, Any]:
        """The result of a finished run.

        Raises:
            RunFolderError: the result cannot be read.
        """
        return self._read(self.result, RunResult, "result")[0]

    def read_facts(self) -> RunFacts:
        """The content of `run.json`.

        Raises:
            RunFolderError: the file cannot be read.
        """
        return self._read(self.run, RunFacts, "facts")[1]

    def read_curve(self) -> RunCurve:
        """The learning curve.

        Raises:
            RunFolderError: the file cannot be read.
        """
        return self._read(self.curve, RunCurve, "learning curve")[1]

    def _read(self, path: Path, kind: type[ContentT], what: str) -> tuple[dict[str, Any], ContentT]:
        """The content of a record as it is written, and with its declared types; errors name it `what`."""
        try:
            content = unseal_or_former(path, _RECORDS.read_json(path))
            return content, TypedReader(path).read(kind, content, "")
        except DataFileError as error:
            raise RunFolderError(self.path, f"its {what} cannot be read ({error})") from error

    def read_config(self) -> dict[str, Any]:
        """The merged recipe as it was written, with the algorithm and the environment.

        Raises:
            RunFolderError: the file cannot be read, or was altered since the run began.
        """
        digest = self.read_facts().recipe_sha256
        try:
            content = _SETTINGS.read_bytes(self.config)
            recipe = _SETTINGS.parse_yaml(self.config, _SETTINGS.decode(self.config, content))
        except DataFileError as error:
            raise RunFolderError(self.path, f"its recipe cannot be read ({error})") from error
        if not isinstance(recipe, dict) or not {"algorithm", "environment"} <= set(recipe):
            raise RunFolderError(self.path, f"{self.config.name!r} holds no recipe")
        if digest and hashlib.sha256(content).hexdigest() != digest:
            raise RunFolderError(self.path, f"{self.config.name!r} was altered since the run began")
        return recipe

    def read_steps(self) -> int:
        """Number of steps trained so far, as last written; 0 where nothing can be read."""
        try:
            told = self.result if self.is_finished else self.progress
            return int(_RECORDS.read_json(told)["steps"])
        except (ValueError, LookupError, TypeError):
            return 0

    def begin(self, recipe: Recipe, settings: Mapping[str, Any], facts: Mapping[str, Any]) -> None:
        """Create the folder and write the recipe and the settings of the run.

        Args:
            recipe: recipe of the training.
            settings: settings other than the recipe, which must be the same when the run is resumed.
            facts: other facts to store with the settings.

        Raises:
            OutputError: the folder cannot be made or written to.
        """
        prepare_folder(self.path)
        versions = list_versions() | {name: version(name) for name in _PACKAGES}
        text = require("yaml").safe_dump(to_plain(recipe.to_plain()), sort_keys=False, allow_unicode=True)
        digest = hashlib.sha256(text.encode()).hexdigest()
        described = {"settings": dict(settings), "versions": versions, "recipe_sha256": digest}
        write_json(self.run, seal({**facts, **described}))
        write_file(self.config, text.encode())  # last: this file says that the folder holds a run

    def check_same(self, recipe: Recipe, settings: Mapping[str, Any]) -> None:
        """Refuse settings that differ from those of the folder.

        Args:
            recipe: recipe of the training.
            settings: settings other than the recipe.

        Raises:
            RunFolderError: settings that differ, or settings of the folder that cannot be read.
        """
        there = {**self.read_config(), **self.read_facts().settings}
        differences = _differences(there, to_plain({**recipe.to_plain(), **settings}))
        if differences:
            raise RunFolderError(
                self.path,
                f"it was trained with other settings: {'; '.join(differences)}",
                "To train with the present ones, choose another folder, or start over with --fresh",
            )

    def hold(self) -> AbstractContextManager[None]:
        """Lock the run against other processes of this machine, until the block or this process ends.

        Raises:
            FolderInUseError: another process holds the lock.
            OutputError: the folder cannot be made or written to.
        """
        return FolderLock(self.path).hold()

    def reserve(self) -> AbstractContextManager[None]:
        """Lock the run against other commands, before any of a command's seeds is trained; see `hold`."""
        return FolderLock(self.path, _RESERVED).hold()

    def remove(self) -> None:
        """Remove the files of the run.

        Raises:
            InvalidValueError: a folder that holds files but no run.
        """
        if self.path.exists():
            if {path.name for path in self.path.iterdir()} - _LOCKS and not (
                self.is_begun or self.run.exists()
            ):
                raise InvalidValueError(
                    "run folder", str(self.path), "an empty one, or one of a training run"
                )
            for path in self.path.iterdir():
                if path.is_dir():
                    shutil.rmtree(path)
                elif path.name not in _LOCKS:
                    path.unlink()


def _differences(there: Mapping[str, Any], requested: Mapping[str, Any], prefix: str = "") -> list[str]:
    """Descriptions of the differences between two nested mappings."""
    found = []
    for key in dict.fromkeys((*there, *requested)):
        old, new = there.get(key), requested.get(key)
        if isinstance(old, Mapping) and isinstance(new, Mapping):
            found += _differences(old, new, f"{prefix}{key}.")
        elif old != new:
            found.append(f"{prefix}{key} is {shortened(old)} there and {shortened(new)} here")
    return found
