"""`LockHolder`: who holds the lock of a folder."""

import json
import os
import platform
import shlex
import sys
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path

from prp_gym.files.json_text import parse_json


@dataclass(frozen=True)
class LockHolder:
    """A process that holds the lock of a folder.

    Attributes:
        process: process id; 0 where it is not known.
        host: name of the machine.
        since: time at which the lock was taken.
        command: command line of the process.
    """

    process: int = 0
    host: str = ""
    since: str = ""
    command: str = ""

    @classmethod
    def this_process(cls) -> "LockHolder":
        """This process, from now on."""
        command = shlex.join([Path(sys.argv[0] or sys.executable).name, *sys.argv[1:]])
        since = datetime.now(UTC).isoformat(timespec="seconds")
        return cls(os.getpid(), platform.node(), since, command)

    @classmethod
    def parse(cls, content: bytes) -> "LockHolder":
        """The holder that a lock file names; one of whom nothing is known if it names none."""
        try:
            known = parse_json(content.decode())
            texts = [str(known[name])[:_LONGEST] for name in ("host", "since", "command")]
            return cls(int(known["process"]), *texts)
        except (ValueError, LookupError, TypeError):
            return cls()

    def to_bytes(self) -> bytes:
        """Content of the lock file."""
        return json.dumps(asdict(self)).encode() + b"\n"

    def __str__(self) -> str:
        if not self.process:
            return "another process"
        return f"process {self.process} on {self.host} since {self.since} ({self.command})"


_LONGEST = 200  # characters of a text in a message
