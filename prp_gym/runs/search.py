"""`Search`: one search for the gains of a controller, from its trials to its validated result."""

from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import gymnasium

from prp_gym.artifacts import list_versions, to_plain, write_json
from prp_gym.errors import InvalidValueError
from prp_gym.extras import version_of
from prp_gym.files.checksum import seal
from prp_gym.processes.folder_lock import FolderLock
from prp_gym.processes.interruption import kept_if_interrupted
from prp_gym.runs.choice import ControllerChoice
from prp_gym.runs.code import running_code
from prp_gym.runs.controllers import Controllers
from prp_gym.runs.evaluation_job import make_environment
from prp_gym.runs.key import key_of
from prp_gym.runs.tuning_candidates import list_candidates
from prp_gym.tuning.gradient_objective import GradientObjective
from prp_gym.tuning.gradient_study import GradientStudy
from prp_gym.tuning.journal import JOURNAL
from prp_gym.tuning.objective import Objective, ScenarioCandidates
from prp_gym.tuning.stored_scores import VALIDATION, StoredScores
from prp_gym.tuning.stored_study import StoredStudy
from prp_gym.tuning.task import GRADIENT, TuningTask
from prp_gym.tuning.trial import Trial
from prp_gym.tuning.tune import Tuned, tune
from prp_gym.tuning.tuned_controller import TunedController, read_tuned_controller
from prp_gym.tuning.validation import Choice, choose, rounded_settings, start_settings

RESULT = "result.json"


@dataclass(frozen=True)
class Search:
    """A search, and all that its result depends on.

    Attributes:
        task: controller, environment, budget and episodes.
        choice: controller with the gains from which the search starts.
        output: folder for the folder of the search.
        command: command line that runs the search.
        resume: whether to go on with the trials of an interrupted run, if there are any, in place of removing
            them.
    """

    task: TuningTask
    choice: ControllerChoice
    output: Path
    command: str
    resume: bool

    @property
    def folder(self) -> Path:
        """Folder of the search."""
        return self.output / f"{self.task.environment_id}_{self.choice.file_name}"

    @property
    def key(self) -> dict[str, Any]:
        """Everything that the trials depend on."""
        code = {**running_code(), "optuna": version_of("optuna")}
        plain: dict[str, Any] = to_plain({**key_of(self.task), "start": asdict(self.choice), "code": code})
        return plain

    def run(
        self,
        controllers: Controllers,
        on_start: Callable[[Sequence[Trial]], None] = lambda trials: None,
        on_trial: Callable[[Trial], None] = lambda trial: None,
        on_validation: Callable[[], None] = lambda: None,
    ) -> TunedController:
        """Spend the budget, validate the best candidates, and write the result.

        Args:
            controllers: source of the controller.
            on_start: function that is called with the trials of an interrupted run.
            on_trial: function that is called after each new trial.
            on_validation: function that is called before the best candidates are validated.

        Raises:
            PRPError: a controller that cannot run on the environment, a budget that is too small, a folder
                that cannot be used or that holds another search.
        """
        with ExitStack() as stack:
            envs = [stack.enter_context(closing(self._environment(name))) for name in self.task.scenarios]
            stack.enter_context(FolderLock(self.folder).hold())
            if not self.resume:
                self._remove()
            conditions = [
                ScenarioCandidates(env, list_candidates(self.choice, controllers, env)) for env in envs
            ]
            study = self._open(conditions)
            stack.enter_context(controllers.reported(self.choice, envs[0]))
            stack.enter_context(kept_if_interrupted(lambda: self._kept(study)))
            on_start(study.trials)
            kind = GradientObjective if self.task.method == GRADIENT else Objective
            training = kind(conditions, self.task.first_seed, self.task.episodes)
            tuned = tune(self.task, training, study, on_trial)
            on_validation()
            choice = choose(
                tuned,
                lambda *drawn: Objective(conditions, *drawn),
                StoredScores(self.folder, self.key),
                self.task.final_episodes,
            )
            result = self._result(conditions, tuned, choice, training.episodes)
            write_json(self.folder / RESULT, seal(asdict(result)))
        return result

    def _environment(self, scenario: str) -> gymnasium.Env[Any, Any]:
        task = self.task
        return make_environment(task.environment_id, scenario, task.control_frequency, task.engine)

    def _remove(self) -> None:
        """Remove what another run of the search has kept."""
        for name in (JOURNAL, VALIDATION, RESULT):
            (self.folder / name).unlink(missing_ok=True)

    def _open(self, conditions: Sequence[ScenarioCandidates]) -> StoredStudy:
        """The trials of the search, those of an interrupted run among them."""
        space = conditions[0].candidates.space
        try:
            kind = GradientStudy if self.task.method == GRADIENT else StoredStudy
            return kind(self.folder, space, self.key, self.task.seed, resume=True)
        except InvalidValueError as error:
            remedy = "; --fresh removes it and starts over, and --output names another folder"
            raise InvalidValueError(error.what, error.value, error.allowed + remedy) from error

    def _kept(self, study: StoredStudy) -> str:
        """What an interrupted search has kept."""
        steps = sum(trial.steps for trial in study.trials)
        same = "the same command" if self.resume else "the same command without --fresh"
        return f"{steps} steps of the budget are kept in {self.folder}; {same} goes on there"

    def _result(
        self, conditions: Sequence[ScenarioCandidates], tuned: Tuned, choice: Choice, episodes: int
    ) -> TunedController:
        task, candidates = self.task, conditions[0].candidates
        kept = choice.validation.kept_start
        factors = choice.trial.factors
        settings = start_settings(candidates) if kept else rounded_settings(candidates, factors)
        rows = tuned.history
        content = TunedController(
            environment=task.environment_id,
            controller=task.controller,
            scenarios=task.scenarios,
            control_frequency=float(task.control_frequency),
            settings=settings,
            budget_steps=task.budget,
            used_steps=tuned.used_steps,
            simulated_seconds=tuned.used_steps / task.control_frequency,
            trials=len(tuned.trials),
            episodes=episodes,
            seconds=sum(trial.seconds for trial in tuned.trials),
            history=tuple((used, trial.score) for used, trial in rows),
            history_by_scenario={
                name: tuple(trial.by_scenario[number] for _, trial in rows)
                for number, name in enumerate(task.scenarios)
            },
            score=choice.trial.score,
            score_of_start=tuned.trials[0].score,
            edges=tuned.ranges.edges,
            validation=choice.validation,
            seed=task.seed,
            command=self.command,
            versions={**list_versions(), "optuna": version_of("optuna")},
            code=self.choice.facts.get("code", {}),
            engine=task.engine,
            method=task.method,
        )
        return read_tuned_controller(to_plain(asdict(content)), self.folder / RESULT)
