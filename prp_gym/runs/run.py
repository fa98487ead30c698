"""Pairs played by whichever workers, those of an interrupted run reused."""

from collections.abc import Sequence
from contextlib import closing

from prp_gym.cli.terminal import make_console, make_progress
from prp_gym.errors import UnknownNameError
from prp_gym.runs.job import Record, run_job
from prp_gym.runs.store import JobStore, JobT
from prp_gym.runs.workers import Workers


def run_jobs(pairs: Sequence[JobT], workers: Workers, finished: JobStore, label: str) -> list[Record]:
    """The records of all pairs in their order; those that are not there yet are played and kept.

    Args:
        pairs: to evaluate.
        workers: who plays them.
        finished: those that an interrupted run has left, and where the others are kept.
        label: of the progress bar.

    Raises:
        InvalidValueError: a worker runs other code than this process.
    """
    records, refused = finished.find(pairs)
    if records or refused:
        note = f"{len(records)} of {len(pairs)} pairs were finished by an interrupted run and are reused."
        if refused:
            note += f" Not reused, as damaged or of other settings or code: {len(refused)}."
        make_console(stderr=True).print(note, highlight=False)
    # the long ones first, so that no worker is left alone with one in the end
    missing = sorted((pair for pair in pairs if pair not in records), key=lambda pair: -pair.episodes)
    with make_progress() as progress:
        total = sum(pair.episodes for pair in pairs)
        bar = progress.add_task(label, total=total, completed=sum(pair.episodes for pair in records))
        with closing(workers.run(run_job, missing)) as played:
            for index, result in played:
                result.check_code()
                finished.keep(missing[index], result.record)
                records[missing[index]] = result.record
                progress.advance(bar, missing[index].episodes)
    return [records[pair] for pair in pairs]


def check_names(kind: str, names: list[str], valid: list[str]) -> list[str]:
    """The names without repetitions, or all valid ones for none.

    Raises:
        UnknownNameError: a name that is not valid.
    """
    for name in names:
        if name not in valid:
            raise UnknownNameError(kind, name, valid)
    return list(dict.fromkeys(names)) or valid
