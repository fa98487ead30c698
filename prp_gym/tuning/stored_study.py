"""The search's memory: Optuna's study in a journal file, which outlives a killed run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from prp_gym.errors import InvalidValueError, MissingPackageError
from prp_gym.evaluation.results import prepare_folder
from prp_gym.tuning.search_space import SearchSpace

if TYPE_CHECKING:
    import optuna

JOURNAL = "study.log"
_NAME = "tuning"
_KEY = "key"


@dataclass(frozen=True)
class Trial:
    """A candidate that was played to the end.

    Attributes:
        factors: by the parameters' names.
        score: mean over the episodes [1].
        steps: that it is charged.
        seconds: that it took [s].
    """

    factors: Mapping[str, float]
    score: float
    steps: int
    seconds: float


class StoredStudy:
    """Proposals for candidates, and what became of them.

    The proposal after n finished trials depends on them and on the seed alone: a search that was killed and
    goes on makes the same proposals as one that was not. A trial that was under way is forgotten, and its
    steps are not charged, since nothing was learned from them. One run at a time may use a folder.

    Args:
        folder: of the journal file.
        space: that is searched.
        key: what the trials depend on beside their factors, as plain JSON.
        seed: of the proposals.
        resume: whether to go on with the trials that are there, if any.

    Raises:
        MissingPackageError: Optuna is not installed.
        InvalidValueError: there are trials, and they are not to be resumed, or have another key.
        OutputError: the folder cannot be made or written to.
    """

    def __init__(
        self, folder: Path, space: SearchSpace, key: Mapping[str, Any], seed: int, resume: bool
    ) -> None:
        self._optuna = _import_optuna()
        self._space, self._seed = space, seed
        path = folder / JOURNAL
        if path.exists() and not resume:
            raise InvalidValueError("output", str(folder), "a folder without a search, or --resume to go on")
        prepare_folder(folder)
        _repair(path)
        backend = self._optuna.storages.journal.JournalFileBackend(str(path))
        self._study = self._optuna.create_study(
            storage=self._optuna.storages.JournalStorage(backend),
            study_name=_NAME,
            direction="maximize",
            load_if_exists=True,
        )
        self._check_key(key, folder)
        self._forget_unfinished()
        self.trials = self._read()

    def propose(self) -> dict[str, float]:
        """The factors of the next candidate; those of the first are 1."""
        index = len(self.trials)
        seed = int(np.random.SeedSequence((self._seed, index)).generate_state(1)[0])
        self._study.sampler = self._optuna.samplers.TPESampler(seed=seed)
        if index == 0:
            self._study.enqueue_trial(self._space.start)
        self._open = self._study.ask(self._distributions())
        return dict(self._open.params)

    def record(self, score: float, steps: int, seconds: float) -> Trial:
        """Finish the candidate that was proposed last."""
        self._open.set_user_attr("steps", steps)
        self._open.set_user_attr("seconds", seconds)
        self._study.tell(self._open, score)
        trial = Trial(dict(self._open.params), score, steps, seconds)
        self.trials.append(trial)
        return trial

    def _distributions(self) -> dict[str, optuna.distributions.BaseDistribution]:
        kind = self._optuna.distributions.FloatDistribution
        return {item.name: kind(item.low, item.high, log=True) for item in self._space.parameters}

    def _check_key(self, key: Mapping[str, Any], folder: Path) -> None:
        """Keep the key of a new study; refuse the trials of another."""
        kept = self._study.user_attrs.get(_KEY)
        if kept is None:
            self._study.set_user_attr(_KEY, dict(key))
        elif kept != key:
            names = sorted(name for name in kept.keys() | key.keys() if kept.get(name) != key.get(name))
            there, here = ({name: known.get(name) for name in names} for known in (kept, key))
            raise InvalidValueError(f"search in {str(folder)!r}", there, f"to resume one of {here}")

    def _forget_unfinished(self) -> None:
        states = self._optuna.trial.TrialState
        for trial in self._study.get_trials(deepcopy=False, states=(states.WAITING, states.RUNNING)):
            if trial.state == states.WAITING:  # enqueued, and not begun
                self._study.ask(self._distributions())
            self._study.tell(trial.number, state=states.FAIL)

    def _read(self) -> list[Trial]:
        complete = (self._optuna.trial.TrialState.COMPLETE,)
        return [
            Trial(
                trial.params, float(trial.values[0]), trial.user_attrs["steps"], trial.user_attrs["seconds"]
            )
            for trial in self._study.get_trials(deepcopy=False, states=complete)
        ]


def _import_optuna() -> Any:
    try:
        import optuna
        import optuna.storages.journal
    except ImportError:
        raise MissingPackageError("optuna", "tune") from None
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    return optuna


def _repair(path: Path) -> None:
    """Take away what a killed run may have left: its lock, and a line that it did not finish."""
    path.with_name(f"{path.name}.lock").unlink(missing_ok=True)
    if path.exists():
        content = path.read_bytes()
        whole = content[: content.rfind(b"\n") + 1]
        if whole != content:
            with path.open("r+b") as file:
                file.truncate(len(whole))
