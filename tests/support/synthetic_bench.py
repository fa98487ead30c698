"""Results of a benchmark that never ran."""

from collections.abc import Callable
from dataclasses import asdict, replace
from typing import Any

from bench.costs import Condition, conditions
from bench.rounds import FREE, FULL, LARGE_PPO, REACHER, Label
from bench.single import CONDITIONS, REACHER_FREQUENCY
from bench.vector import labels

Rate = Callable[[Label], float]


def row(label: Label, rate: float) -> dict[str, Any]:
    """A contender in three rounds, on a machine that became slower."""
    rates = [rate, 0.9 * rate, 0.5 * rate]
    return {**asdict(label), "median": rates[1], "lowest": rates[2], "highest": rates[0], "rates": rates}


def _clocks(label: Label, rate: Rate) -> list[dict[str, Any]]:
    both = (replace(label, clock=clock) for clock in (True, False))
    return [row(one, rate(one)) for one in both]


def _training(rate: Rate) -> list[dict[str, Any]]:
    found = _clocks(Label("dummy", REACHER, REACHER_FREQUENCY, 64), rate)
    ours = [Label("adapter", FREE, frequency, 64, 0) for frequency in (500.0, 50.0)]
    found += [row(label, rate(label)) for label in ours]
    shares = {"train": 0.5, "env_step": 0.3, "policy": 0.15, "other": 0.05}
    return [{**one, "shares": shares} for one in found]


def _costs() -> dict[str, Any]:
    steps = [
        {**vars(condition), "controller_name": "joint_pd", "seconds": part_seconds(condition)}
        for condition in conditions(FULL)
    ]
    reset = {"environment": FREE, "num_envs": 64, "seconds": {"all": 1e-4, "one": 2e-4}}
    return {"steps": steps, "resets": [reset]}


def part_seconds(condition: Condition) -> dict[str, float]:
    """Parts of a step that are not the same in any two conditions [s]."""
    physics = 1e-6 * (
        condition.num_envs + condition.control_frequency / 500 + (0.3 if condition.threads else 0.0)
    )
    physics *= 1.0 if condition.environment == FREE else 7.0
    task, wrapper = 2.0 * physics, 3.0 * physics
    return {"step": 6.0 * physics, "physics": physics, "task": task, "wrapper": wrapper, "controller": 4e-5}


def _peers() -> dict[str, Any]:
    fetch = {"environment": "FetchReach-v4", "control_frequency": 25.0, "substeps": 20, "reason": ""}
    fetch["versions"] = {"mujoco": "3.3.7", "gymnasium-robotics": "1.4.2"}
    panda = {**fetch, "environment": "PandaReach-v3", "reason": "its installation failed: no wheel"}
    panda["versions"] = {}
    label = Label("single", "FetchReach-v4", 25.0, clock=True)
    beside = Label("single", REACHER, REACHER_FREQUENCY)
    return {"rates": [row(label, 1000.0), *_clocks(beside, lambda _: 2000.0)], "peers": [fetch, panda]}


def make_results(rate: Rate, evaluate_seconds: float = 100.0) -> dict[str, Any]:
    """Complete results in which every contender runs at a rate."""
    loops = [Label(kind, *condition) for condition in CONDITIONS for kind in ("bare", "single")]
    loops.append(Label("single", REACHER, REACHER_FREQUENCY))
    many = [*labels(FULL), *(Label("bare_all_cores", *condition) for condition in CONDITIONS)]
    names = ("python", "prp-gym", "gymnasium", "mujoco", "numpy", "stable_baselines3", "torch")
    return {
        "machine": {
            "processor": "Abacus",
            "cores": 2,
            "system": "Linux",
            "architecture": "x86_64",
            "load_average": (0.1, 0.2, 0.3),
        },
        "versions": dict.fromkeys(names, "1.0"),
        "effort": asdict(FULL),
        "single": [one for label in loops for one in _clocks(label, rate)],
        "vector": [one for label in many for one in _clocks(label, rate)],
        "peers": _peers(),
        "training": {LARGE_PPO: _training(rate)},
        "costs": _costs(),
        "memory": [
            {"environment": FREE, "num_envs": count, "bytes_per_env": 1024.0 * kibibytes}
            for count, kibibytes in ((64, 345.6), (256, 30.0), (4096, 4.5))
        ],
        "evaluate": {"seconds": evaluate_seconds},
    }
