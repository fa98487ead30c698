"""What is evaluated: a policy on an environment in a scenario, played in whichever process."""

import hashlib
import platform
from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import Field, dataclass
from functools import cache
from pathlib import Path
from typing import Any, ClassVar, Protocol

import gymnasium

import prp_gym
import prp_gym.agents
import prp_gym.baselines
import prp_gym.envs
from prp_gym.baselines import list_baselines, make_baseline
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.evaluate import episodes_to_run, evaluate
from prp_gym.evaluation.results import describe_evaluation, list_versions, to_plain

_SOURCES = (prp_gym, prp_gym.envs, prp_gym.baselines, prp_gym.agents)
_SUFFIXES = (".py", ".toml")

Record = dict[str, Any]
"""An evaluation as the results file holds it."""


class Job(Protocol):
    """A policy on an environment: a frozen dataclass of plain values, all that its record depends on."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    @property
    def environment_id(self) -> str:
        """For `gymnasium.make`."""

    @property
    def scenario(self) -> str:
        """Of the environment."""

    @property
    def episodes(self) -> int:
        """That are played."""

    @property
    def name(self) -> str:
        """Unlike that of every other pair of the same evaluation, and fit for a file."""

    def play(self) -> Record:
        """Evaluate the policy on the environment."""


@dataclass(frozen=True)
class EvaluationJob:
    """A law on an environment, and all that its evaluation depends on.

    Attributes:
        environment_id: for `gymnasium.make`.
        scenario: of the environment.
        controller: a baseline.
        gains: gain set of the law.
        control_frequency: actions a second [Hz].
        episodes: that are played, 1 in a deterministic scenario.
        seed: of the first episode.
    """

    environment_id: str
    scenario: str
    controller: str
    gains: str
    control_frequency: float
    episodes: int
    seed: int

    @property
    def name(self) -> str:
        """Unlike that of every other pair of the same evaluation."""
        return f"{self.environment_id}_{self.scenario}_{self.controller}"

    def play(self) -> Record:
        """The law with its gain set, on the environment."""
        with closing(make_environment(self.environment_id, self.scenario, self.control_frequency)) as env:
            policy = make_baseline(self.controller, env, self.gains)
            evaluation = evaluate(policy, env, self.episodes, self.seed)
            settings = {"gains": self.gains, **vars(policy.settings)}
            record: Record = to_plain(describe_evaluation(evaluation, self.controller, settings))
        return record


@dataclass(frozen=True)
class JobResult:
    """What a worker hands over.

    Attributes:
        record: of the pair.
        code: that made the record, as `running_code` tells it there.
        node: name of the machine.
    """

    record: Record
    code: dict[str, str]
    node: str

    def check_code(self) -> None:
        """Refuse a record that was not made by the code of this process.

        Raises:
            InvalidValueError: a worker runs other code or versions than this process.
        """
        here = running_code()
        other = {name for name in here.keys() | self.code.keys() if here.get(name) != self.code.get(name)}
        if other:
            there, allowed = ({name: code.get(name) for name in sorted(other)} for code in (self.code, here))
            raise InvalidValueError(
                f"code of a worker on {self.node}", there, f"that of this process, which is {allowed}"
            )


def run_job(pair: Job) -> JobResult:
    """Evaluate a pair; its record is the same wherever the same code plays it, but for the compute time."""
    return JobResult(pair.play(), running_code(), platform.node())


def running_code() -> dict[str, str]:
    """What a record depends on beside its pair: versions, and a digest of this package's files."""
    return {**list_versions(), "sources": source_digest()}


@cache
def source_digest() -> str:
    """SHA-256 over the code and data files of this package, with their names."""
    digest = hashlib.sha256()
    for package in _SOURCES:
        folder = Path(str(package.__file__)).parent
        for path in sorted(folder.rglob("*")):
            if path.suffix in _SUFFIXES and path.is_file():
                name = f"{package.__name__}/{path.relative_to(folder).as_posix()}"
                digest.update(f"{name}\0{path.stat().st_size}\0".encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()


def list_jobs(
    conditions: Iterable[tuple[str, str]],
    controllers: Sequence[str],
    gains: str,
    control_frequency: float,
    episodes: int,
    seed: int,
) -> list[EvaluationJob]:
    """The laws that can run on each environment, tried out before anything is played.

    Args:
        conditions: environment ids and scenarios.
        controllers: baselines.
        gains: gain set of the laws.
        control_frequency: actions a second [Hz].
        episodes: of each pair, where they are not all the same.
        seed: of the first episode.

    Raises:
        UnknownNameError: a gain set that one of the laws lacks.
        InvalidValueError: a control frequency at which the gains of one of the laws are unstable.
    """
    pairs = []
    for environment_id, scenario in conditions:
        with closing(make_environment(environment_id, scenario, control_frequency)) as env:
            eligible = list_baselines(env.get_wrapper_attr("observation_layout"))
            count = episodes_to_run(env, episodes)
            for controller in (name for name in controllers if name in eligible):
                make_baseline(controller, env, gains)
                pairs.append(
                    EvaluationJob(environment_id, scenario, controller, gains, control_frequency, count, seed)
                )
    return pairs


def make_environment(environment_id: str, scenario: str, control_frequency: float) -> gymnasium.Env[Any, Any]:
    """An environment whose actions are torques."""
    return gymnasium.make(environment_id, scenario=scenario, control_frequency=control_frequency)
