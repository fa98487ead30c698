"""Virtual environments of clients: what is installed in them, and the programs that run there."""

import os
import subprocess
import tempfile
import time
import tomllib
import venv
from dataclasses import dataclass
from pathlib import Path

from bench.clients.client import Client
from bench.process import last_line

FOLDER = Path(".venv-clients")
ROOT = Path(__file__).resolve().parents[2]
_INSTALL_LIMIT = 3600  # [s]
_PROGRAM_LIMIT = 900  # [s]
_PINNED = ("torch==2.13.0", "mujoco==4.0.0")


@dataclass(frozen=True)
class Outcome:
    """What became of a client's program.

    Attributes:
        gymnasium: Version of Gymnasium that it runs with; empty if it is not installed.
        message: Last line of the error; empty if the program ran to its end.
        seconds: Time that the program took [s].
    """

    gymnasium: str
    message: str
    seconds: float


def _python(client: Client, folder: Path) -> str:
    return str(folder.resolve() / client.name / "bin" / "python")


def _requirements() -> list[str]:
    """What this package itself requires."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return list(project["dependencies"])


def install(client: Client, folder: Path = FOLDER) -> str:
    """Install a client beside the requirements of this package, unless the same was installed before.

    Returns:
        Reason why it failed; empty if it succeeded.
    """
    wanted = [*_requirements(), *client.requirements]
    record = folder / f"{client.name}.txt"
    if record.exists() and record.read_text(encoding="utf-8").splitlines() == wanted:
        return ""
    folder.mkdir(exist_ok=True)
    constraints = folder / "constraints.txt"
    constraints.write_text("\n".join(_PINNED) + "\n", encoding="utf-8")
    try:
        venv.create(folder / client.name, with_pip=True, clear=True, symlinks=True)
        _pip(client, folder, "--constraint", str(constraints), *wanted)
        if client.alone:
            _pip(client, folder, "--no-deps", client.library)
    except subprocess.CalledProcessError as error:
        return f"its installation failed: {last_line(str(error.stderr or error))}"
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"its installation failed: {last_line(str(error))}"
    record.write_text("\n".join(wanted) + "\n", encoding="utf-8")
    return ""


def _pip(client: Client, folder: Path, *arguments: str) -> None:
    command = [_python(client, folder), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*command, *arguments], check=True, capture_output=True, text=True, timeout=_INSTALL_LIMIT)


def _gymnasium(client: Client, folder: Path) -> str:
    """Version of Gymnasium in a client's environment."""
    code = "from importlib.metadata import version; print(version('gymnasium'))"
    found = subprocess.run([_python(client, folder), "-c", code], capture_output=True, text=True, check=True)
    return found.stdout.strip()


def run(client: Client, folder: Path = FOLDER) -> Outcome:
    """Run a client's program in a temporary folder, with this tree on its path."""
    start, message = time.monotonic(), ""
    with tempfile.TemporaryDirectory() as scratch:
        try:
            subprocess.run(
                [_python(client, folder), str(client.program)],
                check=True,
                capture_output=True,
                text=True,
                cwd=scratch,
                env={**os.environ, "PYTHONPATH": str(ROOT)},
                timeout=_PROGRAM_LIMIT,
            )
        except subprocess.CalledProcessError as error:
            message = last_line(str(error.stderr or error))
        except (OSError, subprocess.TimeoutExpired) as error:
            message = last_line(str(error))
    return Outcome(_gymnasium(client, folder), message, time.monotonic() - start)
