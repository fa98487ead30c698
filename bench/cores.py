"""The bare loop on all cores in parallel: the rate at which the machine runs MuJoCo alone."""

import json
import os
import sys
from collections.abc import Callable, Iterator

import gymnasium

from bench.process import Measuring
from bench.rounds import Contender, Effort, Label, timed
from bench.single import CONDITIONS, bare_loop, keywords
from prp_gym.physics.clock import clock_reading


def count_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class AllCores:
    """One process per core with the bare loops of all conditions; the rates of the processes are added.

    Args:
        effort: Effort of the run, whose duration of episodes is used.
    """

    def __init__(self, effort: Effort) -> None:
        command = [sys.executable, "-m", "bench.cores", str(effort.duration)]
        self._workers = [Measuring(command) for _ in range(count_cores())]
        for worker in self._workers:
            worker.hear()  # until it is ready

    def rate(self, index: int, clock: bool) -> Callable[[float], float]:
        """Rate of all processes together in one of the conditions."""

        def together(seconds: float) -> float:
            for worker in self._workers:
                worker.tell({"index": index, "clock": clock, "seconds": seconds})
            return float(sum(worker.hear()["steps_per_second"] for worker in self._workers))

        return together

    def close(self) -> None:
        """End the processes."""
        for worker in self._workers:
            worker.close()


def contenders(effort: Effort) -> Iterator[Contender]:
    """The bare loops on all cores, with and without MuJoCo's clock."""
    workers = AllCores(effort)
    for index, condition in enumerate(CONDITIONS):
        for clock in (True, False):
            label = Label("bare_all_cores", *condition, clock=clock)
            yield Contender(label, workers.rate(index, clock), workers.close)


def main() -> None:
    """`python -m bench.cores DURATION`: the program of each process."""
    labels = [Label("bare", *condition) for condition in CONDITIONS]
    envs = [gymnasium.make(one.environment, **keywords(one, float(sys.argv[1]))) for one in labels]
    rates = [timed(bare_loop(env)) for env in envs]
    print(json.dumps({"ready": True}), flush=True)
    for line in sys.stdin:
        question = json.loads(line)
        with clock_reading(question["clock"]):
            rate = rates[question["index"]](question["seconds"])
        print(json.dumps({"steps_per_second": rate}), flush=True)


if __name__ == "__main__":
    main()
