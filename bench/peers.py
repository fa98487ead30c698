"""Peers that exclude this suite's requirements, each in a virtual environment of its own: `make peers`."""

import json
import subprocess
import venv
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from bench.process import Measuring, ProcessError, last_line
from bench.rounds import Contender, Label
from prp_gym.artifacts import write_json

FOLDER = Path(".venv-peers")
_CHILD = Path(__file__).with_name("peer_child.py")
_INSTALL_LIMIT = 600  # [s]


@dataclass(frozen=True)
class Peer:
    """An environment of another project.

    Attributes:
        name: Name of its folder.
        module: Module that registers it.
        environment: Environment id.
        control_frequency: Control frequency [Hz].
        substeps: Number of physics steps per environment step.
        packages: Packages to install as name==version; the first is the physics engine.
        clocks: Whether it reads MuJoCo's clock: its default, then the other settings that are measured.
    """

    name: str
    module: str
    environment: str
    control_frequency: float
    substeps: int
    packages: tuple[str, ...]
    clocks: tuple[bool, ...]


PEERS = (
    Peer(
        "fetch",
        "gymnasium_robotics",
        "FetchReach-v4",
        25.0,
        20,
        ("mujoco==3.3.7", "gymnasium-robotics==1.4.2", "gymnasium==1.4.0", "numpy==2.4.6"),
        (True, False),
    ),
    Peer(
        "panda",
        "panda_gym",
        "PandaReach-v3",
        25.0,
        20,
        ("pybullet==3.2.7", "panda-gym==3.0.7", "gymnasium==1.4.0", "numpy==2.4.6"),
        (False,),
    ),
)


def _python(peer: Peer, folder: Path) -> Path:
    return folder / peer.name / "bin" / "python"


def _installed(peer: Peer, folder: Path) -> dict[str, Any]:
    """Record of the last installation: its packages, and the reason if it failed."""
    record = folder / f"{peer.name}.json"
    if not record.exists():
        return {"packages": [], "reason": "not installed; see `make peers`"}
    found: dict[str, Any] = json.loads(record.read_text(encoding="utf-8"))
    return found


def install(peer: Peer, folder: Path = FOLDER) -> str:
    """Install a peer, unless the same versions were installed before.

    Returns:
        Reason why it failed, which the benchmark shows; empty if it succeeded.
    """
    if _installed(peer, folder) == {"packages": list(peer.packages), "reason": ""}:
        return ""
    reason = ""
    command = [str(_python(peer, folder)), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    try:
        venv.create(folder / peer.name, with_pip=True, clear=True)
        subprocess.run(
            [*command, *peer.packages], check=True, capture_output=True, text=True, timeout=_INSTALL_LIMIT
        )
    except subprocess.CalledProcessError as error:
        reason = f"its installation failed: {last_line(str(error.stderr or error))}"
    except (OSError, subprocess.TimeoutExpired) as error:
        reason = f"its installation failed: {last_line(str(error))}"
    write_json(folder / f"{peer.name}.json", {"packages": peer.packages, "reason": reason})
    return reason


def start(peer: Peer, clock: bool, folder: Path) -> tuple[Measuring, dict[str, str]]:
    """Start a peer's process, and read the versions of its packages.

    Raises:
        ProcessError: The peer is not installed or does not run.
    """
    if reason := _installed(peer, folder)["reason"]:
        raise ProcessError(reason)
    names = [package.partition("==")[0] for package in peer.packages]
    process = Measuring(
        [
            str(_python(peer, folder)),
            str(_CHILD),
            peer.module,
            peer.environment,
            "read" if clock == peer.clocks[0] else "stopped",
            *names,
        ]
    )
    try:
        return process, process.hear()
    except ProcessError as error:
        process.close()
        raise ProcessError(f"it does not run: {error}") from error


def _rate(process: Measuring, seconds: float) -> float:
    return process.rate({"seconds": seconds})


def contenders(folder: Path = FOLDER) -> tuple[list[Contender], list[dict[str, Any]]]:
    """Peers that run on this machine, and a description of every peer, with the reason if it does not run."""
    found: list[Contender] = []
    described: list[dict[str, Any]] = []
    for peer in PEERS:
        about: dict[str, Any] = {**asdict(peer), "versions": {}, "reason": ""}
        try:
            for clock in peer.clocks:
                process, about["versions"] = start(peer, clock, folder)
                label = Label("single", peer.environment, peer.control_frequency, clock=clock)
                found.append(Contender(label, partial(_rate, process), process.close))
        except ProcessError as error:
            about["reason"] = str(error)
        described.append(about)
    return found, described


def main(show: Callable[[str], object] = print) -> None:
    """Install every peer; a failure is reported and does not stop the others."""
    for peer in PEERS:
        show(f"{peer.environment}: {install(peer) or 'installed'}")


if __name__ == "__main__":
    main()
