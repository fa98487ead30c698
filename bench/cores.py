"""The bare loop on every core at once: what the machine gives to MuJoCo and nothing else."""

import json
import os
import sys
from collections.abc import Callable, Iterator

import gymnasium

from bench.process import Measuring
from bench.rounds import Contender, Effort, Label, timed
from bench.single import PLACES, bare_loop, keywords
from prp_gym.physics.clock import clock_reading


def count_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class AllCores:
    """A process a core, each with the bare loops of every place; they run at once and their rates are added.

    Args:
        effort: how long episodes are.
    """

    def __init__(self, effort: Effort) -> None:
        command = [sys.executable, "-m", "bench.cores", str(effort.duration)]
        self._workers = [Measuring(command) for _ in range(count_cores())]
        for worker in self._workers:
            worker.hear()  # it is ready

    def rate(self, index: int, clock: bool) -> Callable[[float], float]:
        """The rate of all processes together in one of the places."""

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
    for index, place in enumerate(PLACES):
        for clock in (True, False):
            label = Label("bare_all_cores", *place, clock=clock)
            yield Contender(label, workers.rate(index, clock), workers.close)


def main() -> None:
    """`python -m bench.cores DURATION`: what each process does."""
    labels = [Label("bare", *place) for place in PLACES]
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
