"""One function on many items: in this process, in several, or on a Ray cluster."""

import os
import socket
import sys
import warnings
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from typing import Any, TypeVar

import joblib
from cloudpickle import register_pickle_by_value
from joblib.externals.loky import get_reusable_executor
from joblib.externals.loky.backend import resource_tracker

from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.extras import check
from prp_gym.plugins import load_modules, loaded_plugins
from prp_gym.processes import parent
from prp_gym.processes.interruption import relisten

_PATIENCE = 10  # s, that is waited for an answer or for more work

Item = TypeVar("Item")
Result = TypeVar("Result")


@dataclass(frozen=True)
class Workers:
    """Parallel workers.

    Attributes:
        jobs: number of parallel workers; 1 is this process alone, whatever the backend, and 0 as many as
            there are cores, on a cluster the cluster's.
        backend: one of `BACKENDS`.
    """

    jobs: int = 0
    backend: str = "loky"

    def __post_init__(self) -> None:
        if self.backend not in BACKENDS:
            raise UnknownNameError("backend", self.backend, BACKENDS)
        if self.jobs < 0:
            raise InvalidValueError("jobs", self.jobs, "at least 1, or 0 for as many as there are cores")
        if self.backend == "ray":
            check("ray")

    @property
    def count(self) -> int:
        """Number of parallel workers on this machine."""
        return self.jobs or joblib.cpu_count()

    def run(
        self, function: Callable[[Item], Result], items: Sequence[Item]
    ) -> Generator[tuple[int, Result], None, None]:
        """Apply a function to every item; worker processes first load the plugins of this process.

        Args:
            function: function of a module, which can be pickled; items and results must be picklable, too.
            items: items of work, begun in this order.

        Returns:
            each item's index with its result, as they are finished.

        Raises:
            PluginError: a plugin that a worker process cannot load.
            InvalidValueError: more jobs than a cluster has CPUs, or a cluster that does not answer.
            Exception: what the function raises; what was not finished by then is given up.
        """
        if self.jobs == 1 or len(items) <= 1:
            yield from ((index, function(item)) for index, item in enumerate(items))
            return
        plugins = tuple(loaded_plugins())
        with BACKENDS[self.backend](self.jobs, len(items)) as parallel:
            results = parallel(
                joblib.delayed(_numbered)(function, plugins, index, item) for index, item in enumerate(items)
            )
            try:
                for result in results:  # noqa: UP028 (`yield from` would close them first)
                    yield result
            finally:
                _give_up(results)


def _numbered(
    function: Callable[[Item], Result], plugins: Sequence[str], index: int, item: Item
) -> tuple[int, Result]:
    load_modules(plugins)
    return index, function(item)


def _give_up(results: Generator[object, None, None]) -> None:
    """Close what may have results to come, of which joblib would warn."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".* tasks which were still being processed", UserWarning)
        results.close()


def _parallel(jobs: int, **options: Any) -> Any:
    """Joblib's pool, which hands over each result as soon as there is one."""
    return joblib.Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1, **options)


def _start_quiet_tracker() -> None:
    """Start loky's tracker of semaphores, which clears up after a killed command, without its warnings."""
    quiet = f"ignore::UserWarning:{resource_tracker.__name__}"
    sys.warnoptions.append(quiet)  # options that processes inherit
    try:
        resource_tracker.ensure_running()
    finally:
        sys.warnoptions.remove(quiet)


@contextmanager
def _processes(jobs: int, items: int) -> Iterator[Any]:
    """Processes of this machine, each with one thread for linear algebra, which end with this process."""
    count = min(jobs or joblib.cpu_count(), items)
    _start_quiet_tracker()
    register_pickle_by_value(parent)  # so that a worker waits for its parent's end before it imports anything
    with joblib.parallel_config("loky", inner_max_num_threads=1):
        parallel = _parallel(
            count,
            idle_worker_timeout=_PATIENCE,
            initializer=parent.end_with_parent,
            initargs=(os.getpid(),),
        )
    try:
        yield parallel
    except BaseException:  # an error, an interruption, or results that nobody wants any more
        get_reusable_executor(reuse=True).shutdown(wait=True, kill_workers=True)
        raise
    get_reusable_executor(reuse=True).shutdown(wait=True)


@contextmanager
def _cluster(jobs: int, items: int) -> Iterator[Any]:
    """Workers of the Ray cluster at RAY_ADDRESS, or of one that lives as long as the work does."""
    import ray
    from ray.util.joblib.ray_backend import RayBackend

    started = not ray.is_initialized()
    if started:
        _connect(ray, min(jobs or joblib.cpu_count(), items))
        relisten()  # Ray has a handler of its own for SIGTERM
    try:
        there = int(ray.cluster_resources().get("CPU", 0))
        if jobs > there:
            raise InvalidValueError("jobs", jobs, f"at most {there}, the CPUs of the Ray cluster")
        backend = RayBackend()
        backend.supports_return_generator = True  # joblib asks; results come through callbacks, one by one
        yield _parallel(min(jobs or there, items), backend=backend)
    finally:
        if started:
            ray.shutdown()


def _connect(ray: Any, cpus: int) -> None:
    """Join the cluster at RAY_ADDRESS, or start one that is as large as needed and keeps to itself."""
    quiet = {"log_to_driver": False, "logging_level": "ERROR"}
    address = os.environ.get("RAY_ADDRESS", "")
    if not address:
        os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
        ray.init(address="local", num_cpus=cpus, include_dashboard=False, **quiet)
        return
    try:
        host, _, port = address.removeprefix("ray://").rpartition(":")
        if port.isdecimal():
            socket.create_connection((host, int(port)), _PATIENCE).close()  # Ray itself would try for minutes
        ray.init(address=address, **quiet)
    except (OSError, ValueError) as error:
        raise InvalidValueError("RAY_ADDRESS", address, "the address of a running Ray cluster") from error


BACKENDS: dict[str, Callable[[int, int], AbstractContextManager[Any]]] = {
    "loky": _processes,
    "ray": _cluster,
}
"""By name, how to open a pool for so many jobs at most and so many items."""
