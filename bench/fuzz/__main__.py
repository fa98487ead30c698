"""`python -m bench.fuzz`: strange arguments, files and command lines against every part of the suite."""

import argparse
import sys

from bench.fuzz.case import KINDS
from bench.fuzz.runner import Outcome, run_target
from bench.fuzz.targets import TARGETS

DEFAULT_CASES = 20_000


def main(arguments: list[str] | None = None) -> int:
    """Run the cases, print the table and the faults; returns 1 where there are any."""
    options = _parse(arguments)
    chosen = [target for target in TARGETS if not options.only or target.name in options.only]
    total = sum(target.share for target in chosen)
    outcomes = []
    for target in chosen:
        cases = max(1, round(options.cases * target.share / total))
        outcomes.append(run_target(target, cases, options.seed))
        print(_row(outcomes[-1]), flush=True)
    print(_table(outcomes))
    _print_faults(outcomes, options.seed)
    return int(any(outcome.faults for outcome in outcomes))


def _parse(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m bench.fuzz", description=__doc__)
    parser.add_argument("--cases", type=int, default=DEFAULT_CASES, help="number of cases of all classes")
    parser.add_argument("--seed", type=int, default=0, help="random seed; equal seeds give equal cases")
    names = [target.name for target in TARGETS]
    parser.add_argument("--only", action="append", choices=names, help="one class, may be repeated")
    return parser.parse_args(arguments)


def _row(outcome: Outcome) -> str:
    rate = outcome.cases / max(outcome.seconds, 1e-9)
    faulty = sum(outcome.counts.values())
    return f"{outcome.name}: {outcome.cases} cases, {rate:.0f} per second, {faulty} faulty"


def _table(outcomes: list[Outcome]) -> str:
    rows = [("class", "cases", *KINDS), ("---",) * (2 + len(KINDS)), *(outcome.row for outcome in outcomes)]
    sums = [sum(outcome.row[column] for outcome in outcomes) for column in range(1, 2 + len(KINDS))]
    lines = [f"| {' | '.join(map(str, row))} |" for row in (*rows, ("total", *sums))]
    return "\n".join(["", *lines])


def _print_faults(outcomes: list[Outcome], seed: int) -> None:
    for outcome in outcomes:
        for fault in outcome.faults.values():
            print(f"\n{outcome.name}: {fault.kind}: {fault.where}\n    {fault.example}")
        if outcome.faults:
            again = f"python -m bench.fuzz --only {outcome.name} --seed {seed} --cases {outcome.cases}"
            print(f"    again: {again}")


if __name__ == "__main__":
    sys.exit(main())
