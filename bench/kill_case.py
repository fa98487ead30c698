"""`KillCase`: a small command whose end after an interruption is compared with an uninterrupted one."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from prp_gym.errors import InvalidValueError

OUTPUT = "out"
"""Name of the output folder of every command, in its working folder."""

_ENVIRONMENT = "PRP-JointRegulation-v0"
_CONTROLLERS = ("--baseline", "joint_pd", "--baseline", "joint_inverse_dynamics")
_OF_TIMES = frozenset(
    (
        "checksum",
        "command",
        "created",
        "compute_time",
        "seconds",
        "evaluation_seconds",
        "started",
        "sha256",
        "resumes",
    )
)
"""Keys of what differs between two runs that are otherwise equal."""


@dataclass(frozen=True)
class KillCase:
    """A small command that can be interrupted at any moment.

    Attributes:
        arguments: arguments of the command.
        again: further arguments of the command that goes on after an interruption.
        result: name of the file of results, as a pattern in the output folder.
        goes_on_equally: whether an interrupted command ends with the same results.
    """

    arguments: tuple[str, ...]
    again: tuple[str, ...]
    result: str
    goes_on_equally: bool = True

    def results(self, folder: Path) -> dict[str, Any]:
        """The results in a working folder, by the path of their file, without times.

        Args:
            folder: working folder of the command.

        Raises:
            InvalidValueError: a file that is not JSON.
        """
        files = sorted((folder / OUTPUT).glob(self.result))
        return {str(file.relative_to(folder)): _without_times(read_whole(file)) for file in files}

    def differences(self, reference: Path, folder: Path) -> list[str]:
        """The results in which a working folder differs from that of an uninterrupted command."""
        expected, found = self.results(reference), self.results(folder)
        if not self.goes_on_equally:
            expected, found = ({name: _outline(own) for name, own in r.items()} for r in (expected, found))
        return [name for name in sorted(expected | found) if expected.get(name) != found.get(name)]


def read_whole(path: Path) -> Any:
    """The content of a JSON file.

    Raises:
        InvalidValueError: a file that is not JSON, and so was not written to its end.
    """
    try:
        return json.loads(path.read_bytes())
    except ValueError as error:
        raise InvalidValueError(f"content of {path.name}", str(error), "JSON") from error


def _without_times(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {name: _without_times(own) for name, own in value.items() if not _is_of_times(str(name))}
    if isinstance(value, list):
        return [_without_times(own) for own in value]
    return value


def _is_of_times(name: str) -> bool:
    return name in _OF_TIMES or "compute" in name or "time_of" in name


def _outline(content: Any) -> Any:
    """Of a training what does not depend on its episodes, which are others after an interruption."""
    if "rows" in content:
        return [row["steps"] for row in content["rows"]]
    return {name: content[name] for name in ("environment", "algorithm", "seed", "steps")}


CASES: Mapping[str, KillCase] = {
    "evaluate": KillCase(
        (
            *("evaluate", "--env", _ENVIRONMENT, *_CONTROLLERS),
            *("--scenario", "randomized", "--scenario", "realistic", "--episodes", "4", "--jobs", "2"),
        ),
        (),
        "results.json",
    ),
    "train": KillCase(
        (
            *("train", _ENVIRONMENT, "--seeds", "1", "--jobs", "1", "--eval-episodes", "1"),
            *("--eval-every", "128", "--set", "n_timesteps=512", "--set", "n_envs=2"),
            *("--set", "n_steps=64", "--set", "batch_size=64", "--set", "n_epochs=2"),
            *("--set", "env_kwargs={control_frequency: 50, scenario: randomized}"),
        ),
        ("--resume",),
        "*/*/*/[cr][ue][rs]*.json",
        goes_on_equally=False,
    ),
    "tune": KillCase(
        (
            *("tune", "joint_pd", "--env", "PRP-Adaptive-v0", "--scenario", "randomized"),
            *("--budget", "750", "--episodes", "1", "--control-frequency", "50"),
        ),
        ("--resume",),
        "*/result.json",
    ),
    "compare": KillCase(
        (
            *("compare", "--env", _ENVIRONMENT, *_CONTROLLERS, "--scenario", "randomized"),
            *("--episodes", "2", "--jobs", "2"),
        ),
        (),
        "results.json",
    ),
}
"""The commands, by name."""
