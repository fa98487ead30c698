"""Simulate some runs of the reproduction and judge their checks, up to the first that fails.

A program of its own, so that `make mutants-reproduce` can run it in a tree that has a defect.
"""

import sys
from collections.abc import Sequence

from prp_gym.reproduction import load_catalogue, record_run
from prp_gym.reproduction.outcome import judge_check

FAILED = 1
"""Exit code if a check fails."""


def first_failure(names: Sequence[str]) -> str:
    """The check that fails first, with what it measured; empty if none does.

    Args:
        names: names of runs, in the order in which they are simulated.
    """
    catalogue = load_catalogue()
    checks = [check for experiment in catalogue.experiments.values() for check in experiment.checks]
    for name in names:
        recorded = record_run(catalogue.runs[name])
        for check in checks:
            if check.measure.run != name:
                continue
            verdict = judge_check(check, recorded)
            if verdict.word == "FAIL":
                return f"{check.name}: {verdict.measured.tolist()}, predicted {verdict.predicted.tolist()}"
    return ""


if __name__ == "__main__":
    found = first_failure(sys.argv[1:])
    print(found or "every check passes or is explained")
    sys.exit(FAILED if found else 0)
