"""Measurements in separate processes, which reply to a line of JSON with a line of JSON."""

import json
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from typing import Any


class ProcessError(RuntimeError):
    """A process does not reply; the message is the last line that it wrote to standard error."""


def last_line(text: str) -> str:
    """The last line that is not empty."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1] if lines else "no message"


class Measuring:
    """A process that replies once when it is ready, and then to each request.

    Args:
        command: Command that starts the process.
    """

    def __init__(self, command: Sequence[str]) -> None:
        self._errors = tempfile.TemporaryFile(mode="w+", encoding="utf-8")  # noqa: SIM115
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._errors, text=True
        )

    def tell(self, question: Mapping[str, Any]) -> None:
        """Send a request without waiting for the reply."""
        assert self._process.stdin is not None
        self._process.stdin.write(json.dumps(question) + "\n")
        self._process.stdin.flush()

    def hear(self) -> dict[str, Any]:
        """Wait for a reply; other output of libraries on standard output is skipped.

        Raises:
            ProcessError: The process ended instead.
        """
        assert self._process.stdout is not None
        for line in self._process.stdout:
            if line.startswith("{"):
                answer: dict[str, Any] = json.loads(line)
                return answer
        self._process.wait()
        self._errors.seek(0)
        raise ProcessError(last_line(self._errors.read()))

    def rate(self, question: Mapping[str, Any]) -> float:
        """Request a measurement, and return its steps per second."""
        self.tell(question)
        return float(self.hear()["steps_per_second"])

    def close(self) -> None:
        """End the process; a second call has no effect."""
        if self._process.stdin is not None and not self._process.stdin.closed:
            self._process.communicate()
            self._errors.close()
