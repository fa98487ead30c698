"""`Run`: jobs run by parallel workers, the records of an interrupted run reused, the results written."""

import shlex
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

from prp_gym.artifacts import prepare_folder, require_folder, write_json
from prp_gym.console.activity import Activity
from prp_gym.console.terminal import Terminal
from prp_gym.evaluation.results import describe_run
from prp_gym.processes.folder_lock import FolderLock
from prp_gym.processes.interruption import kept_if_interrupted
from prp_gym.processes.leftovers import remove_leftovers
from prp_gym.runs.controllers import Controllers
from prp_gym.runs.job import Record, run_job
from prp_gym.runs.store import JobStore, JobT
from prp_gym.runs.workers import Workers

JOBS = "jobs"
"""Folder of the records of finished jobs, until the run is complete."""

RESULTS = "results.json"


@dataclass(frozen=True)
class Run:
    """How the jobs of a command are run, and where its results go.

    Attributes:
        folder: folder of the results.
        workers: processes that run the jobs.
        controllers: source of the controllers.
        fresh: whether the jobs that an interrupted run has finished are run again.
        terminal: terminal to which the progress is written.
    """

    folder: Path
    workers: Workers
    controllers: Controllers
    fresh: bool = False
    terminal: Terminal = field(default_factory=Terminal)

    @property
    def store(self) -> JobStore:
        """The finished jobs of the folder."""
        return JobStore(self.folder / JOBS)

    @property
    def results(self) -> Path:
        """Path of the results file."""
        return self.folder / RESULTS

    @property
    def busy(self) -> bool:
        """Whether compute times are measured beside other work."""
        return self.workers.jobs != 1

    @contextmanager
    def hold(self, jobs: Sequence[JobT]) -> Iterator[None]:
        """Lock the folder of the results, and add to an interruption which jobs were kept.

        Args:
            jobs: jobs of the command.

        Raises:
            FolderInUseError: another command writes into the folder.
            OutputError: the folder cannot be made or written to.
        """
        with FolderLock(self.folder).hold(), kept_if_interrupted(lambda: self._kept(jobs)):
            yield

    def records(self, jobs: Sequence[JobT], label: str) -> list[Record]:
        """The records of all jobs in their order.

        Args:
            jobs: jobs to run.
            label: what is done, for the progress.

        Raises:
            OutputError: the folder cannot be made or written to.
            InvalidValueError: a worker runs other code than this process.
        """
        if self.fresh:
            self.store.remove(jobs)
        for folder in (self.folder, self.folder / JOBS):
            prepare_folder(folder)
        remove_leftovers(self.folder / JOBS)
        return run_jobs(jobs, self, label)

    def write(
        self, jobs: Sequence[JobT], records: Sequence[Record], findings: Mapping[str, Any]
    ) -> dict[str, Any]:
        """Write the results file, and remove the files of the finished jobs.

        Args:
            jobs: jobs that were run.
            records: records of the jobs.
            findings: further entries of the results file.

        Returns:
            the content of the results file.

        Raises:
            OutputError: the folder was removed, or cannot be written to.
        """
        require_folder(self.folder)
        described = describe_run(shlex.join(["prp-gym", *sys.argv[1:]]))
        content = {**described, "evaluations": records, **findings}
        write_json(self.results, content)
        self.store.remove(jobs)
        return content

    def _kept(self, jobs: Sequence[JobT]) -> str:
        """What an interrupted command has kept; empty for nothing."""
        kept, _ = self.store.find(jobs)
        same = "the same command without --fresh" if self.fresh else "the same command"
        told = f"{len(kept)} of {len(jobs)} jobs are kept in {self.folder / JOBS}; {same} goes on from there"
        return told if kept else ""


def run_jobs(jobs: Sequence[JobT], run: Run, label: str) -> list[Record]:
    """The records of all jobs in their order; those that are not in the store are run and kept.

    Args:
        jobs: jobs to run.
        run: settings of the run and folder of the finished jobs.
        label: what is done, for the progress.

    Raises:
        InvalidValueError: a worker runs other code than this process.
        OutputError: the folder was removed, or cannot be written to.
    """
    records, refused = run.store.find(jobs)
    if records or refused:
        note = f"{len(records)} of {len(jobs)} jobs were finished by an interrupted run and are reused."
        if refused:
            note += f" Not reused, as damaged or of other settings or code: {len(refused)}."
        run.terminal.note(note)
    # the longest jobs first, so that no worker is left running one alone at the end
    missing = sorted((job for job in jobs if job not in records), key=lambda job: -job.episodes)
    total, before = (sum(job.episodes for job in some) for some in (jobs, records))
    with (
        run.terminal.progress(label, total, "episodes", before) as progress,
        closing(run.workers.run(partial(run_job, run.controllers), missing)) as finished,
    ):
        progress.run(_under_way(missing, records, run.workers))
        for index, result in finished:
            result.check_code()
            require_folder(run.folder / JOBS)
            run.store.keep(missing[index], result.record)
            records[missing[index]] = result.record
            progress.advance(missing[index].episodes)
            progress.run(_under_way(missing, records, run.workers))
    return [records[job] for job in jobs]


def _under_way(jobs: Sequence[JobT], finished: Mapping[JobT, Record], workers: Workers) -> list[Activity]:
    """The jobs that are running: as many as there are workers, which begin them in their order."""
    running = islice((job for job in jobs if job not in finished), workers.count)
    return [Activity(job.name) for job in running]
