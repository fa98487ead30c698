"""Compute the literals anew: say which differ, or write them into the files of the experiments."""

import sys
from functools import cache

import numpy as np

from tests.reproduction.independent.literals import chapters, frozen_checks, with_literals
from tests.reproduction.independent.measures import measure
from tests.reproduction.independent.runs import RUNS
from tests.reproduction.independent.simulation import Signals


@cache
def _signals(run: str) -> Signals:
    return RUNS[run]()


def main(arguments: list[str]) -> int:
    """Every file, or those that are named; with `--write`, its literals are replaced."""
    write = "--write" in arguments
    different = 0
    for path in chapters([name for name in arguments if name != "--write"]):
        text = path.read_text(encoding="utf-8")
        checks = frozen_checks(text)
        results = {row["name"]: measure(_signals(row["measure"]["run"]), row["measure"]) for row in checks}
        for row in checks:
            old = np.ravel(row["predict"]["value"])
            if old.shape != results[row["name"]].shape or not np.allclose(
                old, results[row["name"]], 1e-7, 1e-11
            ):
                different += 1
                print(f"{path.name}: {row['name']}: {old.tolist()}, now {results[row['name']].tolist()}")
        if write:
            path.write_text(with_literals(text, results), encoding="utf-8")
    print(f"{different} literals {'renewed' if write else 'differ'}")
    return 0 if write else min(different, 1)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
