"""`KillTrial`: a command that is ended at some moment and goes on to its end, and what is wrong then."""

import shutil
import signal
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from bench.kill_case import OUTPUT, KillCase, read_whole
from bench.tagged_process import TaggedProcess
from prp_gym.errors import InvalidValueError

_LIMIT = 600.0  # s, of a command to its end
_ORPHANS = 5.0  # s, that workers may outlive a command on a busy machine
_SHARED_MEMORY = Path("/dev/shm")  # where joblib puts files and semaphores of workers
_PNG_END = b"IEND\xaeB`\x82"
_CACHE = "torchinductor_"  # one folder for each user, whatever the command
_ONE_EACH = "events.out.tfevents"  # TensorBoard's files, of which an interrupted training has several


@dataclass(frozen=True)
class KillTrial:
    """A moment at which a command is ended.

    Attributes:
        case: command.
        number: signal that it gets.
        delay: seconds between the start of the command and the signal.
    """

    case: KillCase
    number: signal.Signals
    delay: float

    def faults(self, reference: Path, folder: Path) -> list[str]:
        """What is wrong after the signal or at the end; nothing if all is right.

        Args:
            reference: working folder of an uninterrupted command.
            folder: working folder of this trial, which is empty.
        """
        found = self._end(folder) + _torn(folder)
        ids, errors = run_to_end((*self.case.arguments, "--output", OUTPUT, *self.case.again), folder)
        found += errors + _torn(folder)
        if not errors:
            found += [f"other results: {name}" for name in self.case.differences(reference, folder)]
        found += [f"left: {name}" for name in sorted(_names(folder) ^ _names(reference))]
        return found + [f"left: {name}" for name in _left(folder, ids)]

    def _end(self, folder: Path) -> list[str]:
        """Run the command up to the signal."""
        command = TaggedProcess((*self.case.arguments, "--output", OUTPUT), folder, {})
        try:
            time.sleep(self.delay)
            command.end(self.number)
            late = command.seconds_to_end(_ORPHANS) >= _ORPHANS
            found = ["processes alive after the signal"] if late else []
            if self.number != signal.SIGKILL and "Traceback" in command.errors():
                found.append(f"traceback: {command.errors()[-500:]}")
            return found + [f"left: {name}" for name in _left(folder, [command.id])]
        finally:
            command.close()


def run_to_end(arguments: tuple[str, ...], folder: Path) -> tuple[list[int], list[str]]:
    """Run a command to its end; the id of its process, and what is wrong with it."""
    command = TaggedProcess(arguments, folder, {})
    try:
        code = command.wait(_LIMIT)
        found = [f"exit code {code}: {command.errors()[-500:]}"] if code else []
        if command.seconds_to_end(_ORPHANS) >= _ORPHANS:
            found.append("processes alive after the end")
        return [command.id], found
    except subprocess.TimeoutExpired:
        return [command.id], [f"not at its end after {_LIMIT:g} s"]
    finally:
        command.close()


def in_new_folder(trial: KillTrial, reference: Path) -> list[str]:
    """The faults of a trial in a folder of its own, which is removed."""
    folder = Path(tempfile.mkdtemp(prefix="prp_gym_kills_"))
    try:
        return trial.faults(reference, folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _torn(folder: Path) -> list[str]:
    """Files under their final names that were not written to their end."""
    torn = []
    for path in (folder / OUTPUT).rglob("*"):
        if path.suffix == ".json" and not _is_apart(path.relative_to(folder)):
            try:
                read_whole(path)
            except InvalidValueError as error:
                torn.append(f"torn: {path.relative_to(folder)}: {error}")
        if path.suffix == ".png" and not path.read_bytes().endswith(_PNG_END):
            torn.append(f"torn: {path.relative_to(folder)}")
    return torn


def _is_apart(path: Path) -> bool:
    """Whether a file is a temporary one, or in a checkpoint, which has checksums of its own."""
    return any(part.startswith((".", "checkpoint-")) for part in path.parts)


def _names(folder: Path) -> set[str]:
    """Paths of all files and folders of the output; TensorBoard's files count once for a folder."""
    found = {str(path.relative_to(folder)) for path in (folder / OUTPUT).rglob("*")}
    return {name[: name.index(_ONE_EACH)] if _ONE_EACH in name else name for name in found}


def _left(folder: Path, ids: list[int]) -> list[str]:
    """Temporary files and shared memory of ended processes."""
    shared = _SHARED_MEMORY.iterdir() if _SHARED_MEMORY.is_dir() else ()
    endings = [f"{sign}{number}{sign}" for number in ids for sign in "-_"]
    own = [path for path in shared if any(ending in path.name for ending in endings)]
    temporary = [path for path in (folder / "tmp").iterdir() if not path.name.startswith(_CACHE)]
    return [str(path) for path in (*temporary, *own)]
