"""Cases of command lines, run in this process: every one of them fails early, or works very little."""

import contextlib
import io
import random
import sys
from pathlib import Path
from unittest import mock

from hypothesis import strategies as st

from bench.fuzz.target import Prepared, Target
from prp_gym.agents.sb3.packages import require
from prp_gym.cli.main import main

_TASK = "PRP-Adaptive-v0"
_SMALL = ["--scenario", "report", "--episodes", "1", "--jobs", "1", "--output", "work/results"]
_LINES: tuple[tuple[list[str], tuple[str, ...]], ...] = (
    (
        ["evaluate", "--env", _TASK, "--baseline", "joint_pd", *_SMALL],
        (
            "--env",
            "--baseline",
            "--scenario",
            "--seed",
            "--gains",
            "--set",
            "--control-frequency",
            "--backend",
        ),
    ),
    (
        ["evaluate", "--env", _TASK, "--baseline", "joint_pd", *_SMALL, "--control-frequency", "3"],
        ("--episodes", "--jobs", "--plugin", "--output", "--fresh"),
    ),
    (
        ["compare", "--env", _TASK, "--episodes", "0"],
        (
            "--env",
            "--agent",
            "--scenario",
            "--seed",
            "--output",
            "--jobs",
            "--backend",
            "--audit",
            "--plugin",
        ),
    ),
    (
        ["tune", "joint_pd", "--env", _TASK, "--budget", "10", "--output", "work/tuning"],
        ("--env", "--baseline", "--like", "--scenario", "--control-frequency", "--episodes", "--seed"),
    ),
    (
        ["tune", "joint_pd", "--env", _TASK, "--budget", "10", "--output", "work/tuning"],
        ("--gains", "--set", "--resume", "--plugin", "--budget"),
    ),
    (
        ["train", _TASK, "--set", "no_setting=1", "--output", "work/runs"],
        ("--algo", "--action-mode", "--seeds", "--first-seed", "--config", "--set", "--eval-every", "--jobs"),
    ),
    (
        ["train", _TASK, "--eval-episodes", "0", "--output", "work/runs"],
        ("--set", "--algo", "--checkpoint-every", "--manifest", "--config", "--seeds", "--tensorboard"),
    ),
    (
        ["ship", "--runs", "work/none", "--output", "work/agents"],
        ("--runs", "--manifest", "--config", "--episodes", "--jobs", "--plugin"),
    ),
    (
        ["export", "none.zip", "--env", _TASK, "--output", "work/agent"],
        (
            "--env",
            "--algorithm",
            "--normalizer",
            "--scenario",
            "--action-mode",
            "--control-frequency",
            "--seed",
        ),
    ),
    (["reproduce", "--figure", "999", "--output", "work/figures"], ("--figure", "--output", "--plugin")),
    (["list"], ("--matrix", "--modes", "--algorithms", "--metrics", "--none")),
)
_TEXTS = (
    *("", " ", "nan", "inf", "-inf", "-1", "0", "1", "0.5", "1e308", "5e-324", "9" * 400, "9" * 5000, "1j"),
    *(
        "a",
        "x" * 5000,
        "\u202e",
        "a b",
        "none.py:None",
        "none.toml",
        "none:None",
        "/dev/null",
        ".",
    ),
    *("PRP-Force-v0", "PRP-JointTracking-v1", "joint_pd", "torque", "report", "randomized", "ppo", "ray"),
    *("stiffness=1e999", "stiffness=nan", "stiffness=[1,", "stiffness", "=", "=1", "stiffness='a'", "a=1"),
    *(
        "gamma=abc",
        "gamma=.nan",
        "n_epochs=0",
        "n_envs=1000000000",
        "n_envs=-1",
        "a.b=1",
    ),
    *("policy_kwargs=1", "policy_kwargs.net_arch=[0]", "learning_rate=lin_a", "env_kwargs={a: *a}", "--help"),
)


def _line(seed: int) -> list[str]:
    """A command line with one or two options added, replaced or cut."""
    rng = random.Random(seed)
    base, options = _LINES[rng.randrange(len(_LINES))]
    line = list(base)
    for _ in range(rng.choice((1, 1, 2))):
        option = rng.choice(options)
        value = rng.choice(_TEXTS)
        if option in line and option not in _FLAGS:
            line[line.index(option) + 1] = value
        else:
            line += [option] if option in _FLAGS else [option, value]
    if rng.random() < 0.05 and line[0] not in ("evaluate", "compare", "train"):
        line = line[: rng.randrange(1, len(line))]
    return line


_FLAGS = (
    "--fresh",
    "--resume",
    "--audit",
    "--tensorboard",
    "--matrix",
    "--modes",
    "--algorithms",
    "--metrics",
)
_TOO_LONG = (["evaluate"], ["compare"], ["reproduce"], ["list"])


def _prepare(_: Path) -> Prepared:
    require()  # takes seconds, and must not be interrupted

    def call(line: list[str]) -> object:
        text = io.StringIO()
        argv = mock.patch.object(sys, "argv", ["prp-gym", *line])
        with argv, contextlib.redirect_stdout(text), contextlib.redirect_stderr(text):
            _run()
        return None

    lines = st.integers(0, 2**40).map(_line).filter(lambda line: line not in _TOO_LONG)
    return Prepared(lines, call)


def _run() -> None:
    """The command; its usage errors, and what it tells with exit code 0, are no faults."""
    try:
        main()
    except SystemExit as end:
        if end.code not in (None, 0, 2):
            raise


COMMANDS = (Target("commands", _prepare, 0.2),)
