"""The trials of a search: Optuna's study in a journal file, which outlives a killed run."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from prp_gym.artifacts import prepare_folder, require_folder
from prp_gym.errors import DataFileError, InvalidValueError, MissingPackageError, OutputError
from prp_gym.files.checksum import KEY
from prp_gym.tuning.candidates import Space
from prp_gym.tuning.journal import JOURNAL, KEY_OF_SEARCH, SLOPES, STUDY_NAME, read_key, trial_checksum
from prp_gym.tuning.local_step import is_local, is_of_few, local_step
from prp_gym.tuning.search_space import Parameter
from prp_gym.tuning.trial import Trial
from prp_gym.tuning.widening import Ranges, ranges_after

if TYPE_CHECKING:
    import optuna


ROUND = 4
"""Candidates of a round, in which none knows the score of another one; the start is a round of its own."""


class _LockOfFolder:
    """Optuna's lock of a journal, which is not needed: the whole folder is locked by `FolderLock`."""

    def acquire(self) -> bool:
        """Do nothing."""
        return True

    def release(self) -> None:
        """Do nothing."""


class StoredStudy:
    """Proposals for candidates, and their scores.

    The first candidate is the centre of the space. Of the others, one in six comes from Optuna's sampler
    (TPE), which looks everywhere and learns from all trials; five are steps from the best one so
    far, since in many dimensions a small budget finds little that is better than gains already good but near
    them. Two of these five change few of the factors, but by much. The ranges of the factors grow where the
    best candidate lies at their edge; see `ranges_after`.

    Candidates come in rounds of four, which are run side by side since that takes little longer than one. The
    proposals of a round depend on the trials before it and on the seed alone: a search that was killed and
    goes on makes the same proposals as one that was not. The journal holds finished trials alone, each
    written in one piece: one that was under way when the run was killed is run again, and its steps are
    counted once, since nothing was learned from them before. One run at a time may use a
    folder, which its user locks with `FolderLock`.

    Args:
        folder: folder of the journal file.
        space: space that is searched.
        key: everything that the trials depend on besides their factors, as plain JSON.
        seed: seed of the proposals.
        resume: whether to go on with the trials that are there, if any.

    Attributes:
        trials: finished trials in their order.
        seed: seed of the proposals.
        candidates_of_a_round: number of candidates in a round.

    Raises:
        MissingPackageError: Optuna is not installed.
        InvalidValueError: there are trials, and they are not to be resumed, or have another key.
        DataFileError: a journal that is damaged or altered; it is left as it is.
        OutputError: the folder cannot be made or written to.
    """

    candidates_of_a_round: ClassVar[int] = ROUND

    def __init__(self, folder: Path, space: Space, key: Mapping[str, Any], seed: int, resume: bool) -> None:
        self._optuna = _import_optuna()
        self._space, self.seed, self._key = space, seed, dict(key)
        self._journal = self._open_journal(folder, resume)
        if not self._journal.user_attrs:
            self._journal.set_user_attr(KEY_OF_SEARCH, self._key)
        self.trials = [_read(trial) for trial in self._journal.get_trials(deepcopy=False)]

    def ranges(self, trials: Sequence[Trial]) -> Ranges:
        """The ranges of the factors after some trials."""
        return ranges_after(self._space.parameters, trials)

    @property
    def known(self) -> list[Trial]:
        """The trials before the current round, on which its proposals depend."""
        return self.trials[: _first_of_round(len(self.trials), self.candidates_of_a_round)]

    def propose(self) -> list[dict[str, float]]:
        """The factors of the candidates that are left of the current round; the first round is the start."""
        index = len(self.trials)
        if index == 0:
            return [self._space.start]
        known = self.known
        parameters = self.ranges(known).parameters
        numbers = range(index, len(known) + self.candidates_of_a_round)
        return [self._propose(number, parameters, known) for number in numbers]

    def record(self, trial: Trial) -> None:
        """Keep a finished trial.

        Raises:
            OutputError: the folder was removed, or cannot be written to.
        """
        try:
            require_folder(self._path.parent)
            self._journal.add_trial(self._sealed(trial))
        except OSError as error:  # a line that was not written to its end is taken away by the next run
            raise OutputError(self._path, error) from error
        self.trials.append(trial)

    def _propose(
        self, index: int, parameters: Sequence[Parameter], known: Sequence[Trial]
    ) -> dict[str, float]:
        seeds = np.random.SeedSequence((self.seed, index))
        if is_local(index):
            return local_step(parameters, known, np.random.default_rng(seeds), is_of_few(index))
        return self._sample(parameters, known, int(seeds.generate_state(1)[0]))

    def _sample(self, parameters: Sequence[Parameter], known: Sequence[Trial], seed: int) -> dict[str, float]:
        """A candidate of Optuna's sampler, which sees the trials in the ranges as they are now."""
        sampler = self._optuna.samplers.TPESampler(seed=seed, multivariate=True)
        study = self._optuna.create_study(direction="maximize", sampler=sampler)
        distributions = self._distributions(parameters)
        study.add_trials([self._frozen(trial, distributions, {}) for trial in known])
        return dict(study.ask(distributions).params)

    def _distributions(self, parameters: Sequence[Parameter]) -> dict[str, Any]:
        kind = self._optuna.distributions.FloatDistribution
        return {item.name: kind(item.low, item.high, log=True) for item in parameters}

    def _frozen(
        self, trial: Trial, distributions: Mapping[str, Any], attributes: Mapping[str, Any]
    ) -> optuna.trial.FrozenTrial:
        frozen: optuna.trial.FrozenTrial = self._optuna.trial.create_trial(
            params=dict(trial.factors),
            distributions=dict(distributions),
            value=trial.score,
            user_attrs=dict(attributes),
        )
        return frozen

    def _sealed(self, trial: Trial) -> optuna.trial.FrozenTrial:
        """A finished trial for the journal, with a checksum among its attributes."""
        distributions = self._distributions(self.ranges(self.trials).parameters)
        to_json = self._optuna.distributions.distribution_to_json
        plain = {name: to_json(item) for name, item in distributions.items()}
        attributes: dict[str, Any] = {
            "steps": trial.steps,
            "seconds": trial.seconds,
            "by_scenario": list(trial.by_scenario),
            "stopped": trial.stopped,
        }
        if trial.slopes:
            attributes[SLOPES] = dict(trial.slopes)
        digest = trial_checksum(trial.score, trial.factors, plain, attributes)
        return self._frozen(trial, distributions, {**attributes, KEY: digest})

    def _open_journal(self, folder: Path, resume: bool) -> optuna.Study:
        path = self._path = folder / JOURNAL
        if os.path.exists(path) and not resume:
            raise InvalidValueError("output", str(folder), "a folder without a search, or --resume to go on")
        prepare_folder(folder)
        kept = read_key(path, self._space) if os.path.exists(path) else {}
        if kept and kept != self._key:
            names = sorted(
                name for name in kept.keys() | self._key.keys() if kept.get(name) != self._key.get(name)
            )
            there, here = ({name: known.get(name) for name in names} for known in (kept, self._key))
            raise InvalidValueError(f"search in {str(folder)!r}", there, f"to resume one of {here}")
        try:
            _repair(path)
            return self._replay(path)
        except OSError as error:
            raise OutputError(path, error) from error
        except Exception as error:  # Optuna raises any exception about a part that it alone reads
            reason = f"Optuna cannot read it ({type(error).__name__}: {error})"
            raise DataFileError(path, reason, "It is left as it is; to search anew, move it away") from error

    def _replay(self, path: Path) -> optuna.Study:
        backend = self._optuna.storages.journal.JournalFileBackend(str(path), _LockOfFolder())
        study: optuna.Study = self._optuna.create_study(
            storage=self._optuna.storages.JournalStorage(backend),
            study_name=STUDY_NAME,
            direction="maximize",
            load_if_exists=True,
        )
        return study


def _first_of_round(index: int, size: int) -> int:
    """Index of the first trial in the round of a trial, of rounds of a size."""
    return 0 if index == 0 else 1 + (index - 1) // size * size


def _read(trial: optuna.trial.FrozenTrial) -> Trial:
    known = trial.user_attrs
    scores = tuple(float(score) for score in known["by_scenario"])
    score, slopes = float(trial.values[0]), known.get(SLOPES, {})
    return Trial(
        dict(trial.params), score, known["steps"], known["seconds"], scores, known["stopped"], slopes
    )


def _import_optuna() -> Any:
    try:
        import optuna
        import optuna.storages.journal
    except ImportError:
        raise MissingPackageError("optuna", "tune") from None
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    return optuna


def _repair(path: Path) -> None:
    """Take away what a killed run may have left: Optuna's lock, and a line that it did not finish."""
    path.with_name(f"{path.name}.lock").unlink(missing_ok=True)  # of version 0.1, which used that lock
    if os.path.exists(path):
        content = path.read_bytes()
        whole = content[: content.rfind(b"\n") + 1]
        if whole != content:
            with path.open("r+b") as file:
                file.truncate(len(whole))
