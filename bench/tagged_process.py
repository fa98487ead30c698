"""A command in a process, all of whose descendants can be found, also those whose parent has ended."""

import os
import signal
import subprocess
import sys
import tempfile
import time
import uuid
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path

_TAG = "PRP_GYM_TAG"
_EVERY = 0.02  # s


class TaggedProcess:
    """A `prp-gym` command whose processes carry a tag in their environment.

    Args:
        arguments: arguments of the command.
        folder: working folder, in which the command's temporary files get a folder of their own.
        environment: further environment variables.
    """

    def __init__(self, arguments: Sequence[str], folder: Path, environment: Mapping[str, str]) -> None:
        self._tag = uuid.uuid4().hex
        self._errors = tempfile.TemporaryFile(mode="w+", encoding="utf-8")  # noqa: SIM115
        self.temporary = folder / "tmp"
        self.temporary.mkdir(exist_ok=True)
        tagged = {_TAG: self._tag, "TMPDIR": str(self.temporary), "COLUMNS": "200"}
        self._process = subprocess.Popen(
            [sys.executable, "-m", "prp_gym.cli.main", *arguments],
            cwd=folder,
            env={**os.environ, **environment, **tagged},
            stdout=subprocess.DEVNULL,
            stderr=self._errors,
            start_new_session=True,
        )
        self.id = self._process.pid

    def alive(self) -> list[int]:
        """Process ids of the command and of all its descendants that are alive."""
        tag = f"{_TAG}={self._tag}".encode()
        found = []
        for entry in Path("/proc").iterdir():
            if entry.name.isdecimal():
                with suppress(OSError):
                    if tag in (entry / "environ").read_bytes():
                        found.append(int(entry.name))
        return found

    def wait_for_workers(self, count: int, limit: float = 60.0) -> None:
        """Wait until the command has so many processes.

        Raises:
            TimeoutError: it does not have them within the limit [s], or has ended.
        """
        end = time.monotonic() + limit
        while len(self.alive()) < count:
            if time.monotonic() > end or self._process.poll() is not None:
                raise TimeoutError(f"{len(self.alive())} processes in place of {count}: {self.errors()}")
            time.sleep(_EVERY)

    def end(self, number: signal.Signals) -> None:
        """Send a signal to the command itself; nothing if it has ended."""
        with suppress(ProcessLookupError):
            self._process.send_signal(number)

    def seconds_to_end(self, limit: float) -> float:
        """Seconds until all processes have ended, at most the limit [s]; those left then are killed."""
        start = time.monotonic()
        while (left := self._left()) and time.monotonic() < start + limit:
            time.sleep(_EVERY)
        for process in left:
            with suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)
        return time.monotonic() - start

    def _left(self) -> list[int]:
        self._process.poll()  # takes leave of the command, which would be found as long as nobody does
        return self.alive()

    def wait(self, limit: float) -> int:
        """The exit code of the command.

        Raises:
            subprocess.TimeoutExpired: it has not ended within the limit [s].
        """
        return self._process.wait(limit)

    def errors(self) -> str:
        """What was written to standard error."""
        self._errors.seek(0)
        return self._errors.read()

    def close(self) -> None:
        """End whatever is left, and close the file of standard error."""
        self.seconds_to_end(0.0)
        self._process.wait()
        self._errors.close()
