"""What a job is: a policy on an environment in a scenario, evaluated in any process."""

import platform
from collections.abc import Iterable, Mapping
from dataclasses import Field, dataclass
from typing import Any, ClassVar, Protocol

from prp_gym.artifacts import to_plain
from prp_gym.errors import InvalidValueError
from prp_gym.evaluation.evaluate import Evaluation
from prp_gym.evaluation.results import describe_evaluation
from prp_gym.runs.code import running_code
from prp_gym.runs.controllers import Controllers
from prp_gym.runs.key import key_of
from prp_gym.tasks.spec import TASKS

Record = dict[str, Any]
"""An evaluation as the results file holds it."""


class Job(Protocol):
    """A policy on an environment: a frozen dataclass of plain values, all that its record depends on."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    @property
    def environment_id(self) -> str:
        """Id of the environment, for `gymnasium.make`."""

    @property
    def scenario(self) -> str:
        """Scenario of the environment."""

    @property
    def episodes(self) -> int:
        """Number of episodes."""

    @property
    def name(self) -> str:
        """Name that no other job of the same run has, fit for a file."""

    def run(self, controllers: Controllers) -> Record:
        """Evaluate the policy on the environment.

        Args:
            controllers: source of the controllers.
        """


@dataclass(frozen=True)
class JobResult:
    """Result that a worker returns.

    Attributes:
        record: record that the job produced.
        code: digest of the code that made the record, as `running_code` returns it in the worker's process.
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


def run_job(controllers: Controllers, job: Job) -> JobResult:
    """Run a job; its record is the same wherever the same code runs it, but for the compute time."""
    return JobResult(job.run(controllers), running_code(), platform.node())


def make_record(
    evaluation: Evaluation, policy: str, settings: Mapping[str, Any], revisions: Mapping[str, int]
) -> Record:
    """An evaluation as the results file holds it.

    Args:
        evaluation: evaluation of the policy.
        policy: name of the policy.
        settings: settings of the policy.
        revisions: behaviour revisions beside that of the task: that of the controller, or of the task on
            which an agent was trained.
    """
    described = describe_evaluation(evaluation, policy, settings)
    task = task_revision(str(described["environment"]))
    record: Record = to_plain({**described, "revisions": {"task": task, **revisions}})
    return record


def task_revision(environment_id: str) -> int:
    """Revision of the behaviour of a task; 1 for a task that is not declared."""
    return TASKS[environment_id].revision if environment_id in TASKS else 1


def describe_jobs(jobs: Iterable[Job]) -> list[list[Any]]:
    """All that the results of some jobs depend on, without the code, as plain values.

    Args:
        jobs: jobs of a command.
    """
    return [[type(job).__name__, to_plain(key_of(job))] for job in jobs]
