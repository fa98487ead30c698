"""Values that the page's texts mention, each from the condition that the text is about."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from bench.goals import GROWTH_SIZES
from bench.rounds import ALL_CORES, FREE, LARGE_PPO, REACHER, Label, find, ratios
from bench.single import FREQUENCIES, REACHER_FREQUENCY

Results = Mapping[str, Any]

KEPT_UP_TO = 128
"""Largest vector environment whose environments have simulation data of their own, in `prp_gym.physics`."""


def numbers(results: Results) -> dict[str, str]:
    """Values of the texts on limits; those of conditions that a run left out are missing."""
    return dict(
        [*_steps(results), *_growth(results), *_clock(results), *_training(results), *_evaluate(results)]
    )


def _steps(results: Results) -> Iterator[tuple[str, str]]:
    """`n64_500_task`, `one_core_500_task` etc.: parts of an environment's step in free space [µs]."""
    for row in results["costs"]["steps"]:
        if row["environment"] != FREE:
            continue
        condition = f"n{row['num_envs']}_{row['control_frequency']:g}"
        if row["num_envs"] > 1 and row["threads"] != ALL_CORES:
            condition = f"one_core_{row['control_frequency']:g}"
            yield "one_core_count", str(row["num_envs"])
        for part, seconds in row["seconds"].items():
            yield f"{condition}_{part}", f"{1e6 * seconds:.1f}"


def _growth(results: Results) -> Iterator[tuple[str, str]]:
    """`growth_500_physics` etc.: from the fewest to the most environments [µs]."""
    seconds = {
        (row["control_frequency"], row["num_envs"]): row["seconds"]
        for row in results["costs"]["steps"]
        if row["environment"] == FREE and row["threads"] == ALL_CORES
    }
    few, many = GROWTH_SIZES
    for frequency in FREQUENCIES:
        if {(frequency, few), (frequency, many)} <= set(seconds):
            for part in ("physics", "task", "wrapper"):
                span = (1e6 * seconds[frequency, count][part] for count in (few, many))
                yield f"growth_{frequency:g}_{part}", " to ".join(f"{value:.2f}" for value in span)


def _clock(results: Results) -> Iterator[tuple[str, str]]:
    """Rate of a loop on one core without MuJoCo's clock, relative to the rate with it."""
    loops = {"reacher_gain": Label("single", REACHER, REACHER_FREQUENCY)}
    for frequency in FREQUENCIES:
        loops[f"bare_{frequency:g}_gain"] = Label("bare", FREE, frequency)
    for name, label in loops.items():
        yield name, _gain(results["single"], label)


def _gain(rows: Any, label: Label) -> str:
    clocked = Label(label.kind, label.environment, label.control_frequency, clock=True)
    return f"{np.median(ratios(rows, label, clocked)):.2f}"


def _training(results: Results) -> Iterator[tuple[str, str]]:
    """Shares of training [%], and its rate relative to Reacher-v5 if environments took no time."""
    rows = results["training"][LARGE_PPO]
    count = int(rows[0]["num_envs"])
    peer = Label("dummy", REACHER, REACHER_FREQUENCY, count, clock=True)
    for name, share in find(rows, peer)["shares"].items():
        yield f"ppo_reacher_{name}", f"{100 * share:.0f}"
    for frequency in FREQUENCIES:
        own = Label("adapter", FREE, frequency, count, ALL_CORES)
        shares = find(rows, own)["shares"]
        for name, share in shares.items():
            yield f"ppo_{frequency:g}_{name}", f"{100 * share:.0f}"
        most = np.median(ratios(rows, own, peer)) / (1.0 - shares["env_step"])
        yield f"ppo_{frequency:g}_most", f"{most:.2f}"


def _evaluate(results: Results) -> Iterator[tuple[str, str]]:
    if "evaluate" in results:
        yield "evaluate_seconds", f"{results['evaluate']['seconds']:.0f}"
        yield "cores", str(results["machine"]["cores"])


def memory_numbers(results: Results) -> dict[str, str]:
    """Memory of an environment that keeps its simulation data, and of one that does not [KiB]."""
    rows = sorted(
        (row for row in results["memory"] if row["environment"] == FREE), key=lambda r: r["num_envs"]
    )
    kept = [row for row in rows if row["num_envs"] <= KEPT_UP_TO]
    texts = {"kept": kept[-1]["bytes_per_env"], "shared": rows[-1]["bytes_per_env"]}
    sizes = {"kept_up_to": str(KEPT_UP_TO), "memory_size": str(rows[-1]["num_envs"])}
    return sizes | {f"memory_{name}": f"{value / 1024:.3g}" for name, value in texts.items()}
