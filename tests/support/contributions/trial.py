"""Runs the commands in a copy of the repository with the contributions, all in one process.

`python -m tests.support.contributions.trial FOLDER`, run in the copy, writes into FOLDER what each command
printed, the files that the commands write, and the conformance tests that were collected and that passed.
"""

import json
import sys
from functools import partial
from pathlib import Path

import gymnasium
import pytest
from typer.testing import CliRunner

import prp_gym
from docs.generate import main as generate_pages
from prp_gym.cli.main import app
from tests.support.contributions import ACTION_MODE, ALGORITHM, CONTROLLER, TASK

COMMON = ("--env", TASK.name, "--scenario", "report", "--jobs", "1")
BOTH = ("--baseline", CONTROLLER.name, "--baseline", "joint_pd")
DURATION = 1.0  # s, of the episodes
TUNING_STEPS = 1000
TRAINING_STEPS = 64
RECIPE = (
    *("env_kwargs.control_frequency=50", "env_kwargs.duration=0.4", f"n_timesteps={TRAINING_STEPS}"),
    *("n_envs=2", "policy_kwargs.net_arch=[4]"),
)
TRAINING = (
    *("--algo", ALGORITHM.name, "--action-mode", ACTION_MODE.name, "--no-tensorboard", "--jobs", "1"),
    *("--eval-every", str(TRAINING_STEPS), "--eval-episodes", "2"),
    *(part for text in RECIPE for part in ("--set", text)),
)
COMMANDS = {
    "list": ("list",),
    "list_matrix": ("list", "--matrix"),
    "list_modes": ("list", "--modes"),
    "list_algorithms": ("list", "--algorithms"),
    "list_metrics": ("list", "--metrics"),
    "help_train": ("train", "--help"),
    "evaluate": ("evaluate", *COMMON, *BOTH),
    "compare": ("compare", *COMMON, *BOTH),
    "tune": (
        "tune",
        CONTROLLER.name,
        "--env",
        TASK.name,
        "--scenario",
        "report",
        "--budget",
        str(TUNING_STEPS),
    ),
    "train": ("train", TASK.name, *TRAINING),
}
OUTPUTS = {"evaluate": "results", "compare": "comparison", "tune": "tuning", "train": "runs"}
"""Folders into which commands write."""

FILES = (
    *(f"tests/conformance/test_{name}.py" for name in ("environments", "controllers", "action_modes")),
    "tests/agents/training/test_train.py",
)
"""Test files whose cases are those of the registries."""

CHOSEN = (
    f"test_stable_baselines3s_checker_is_satisfied and {TASK.name}",
    f"test_episodes_side_by_side_are_controlled_as_each_on_its_own and {CONTROLLER.name}",
    f"test_checkers_are_satisfied and {ACTION_MODE.name}",
    f"test_run_folder_holds_what_was_used_and_what_came_out and {ALGORITHM.name}",
)


class Recorder:
    """A pytest plugin that records which tests are collected and which pass."""

    def __init__(self) -> None:
        self.collected: list[str] = []
        self.passed: list[str] = []

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Record all items, before any is deselected."""
        self.collected += [item.nodeid for item in items]

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Record an item that passed."""
        if report.when == "call" and report.passed:
            self.passed.append(report.nodeid)


def run_commands(folder: Path) -> dict[str, str]:
    """What each command prints; an error of a command is raised."""
    printed = {}
    for name, arguments in COMMANDS.items():
        output = ("--output", str(folder / OUTPUTS[name])) if name in OUTPUTS else ()
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(gymnasium, "make", partial(gymnasium.make, duration=DURATION))
            result = CliRunner().invoke(
                app, [*arguments, *output], env={"COLUMNS": "160"}, catch_exceptions=False
            )
        printed[name] = result.output
        if result.exit_code:
            raise RuntimeError(f"prp-gym {name} ended with exit code {result.exit_code}: {result.output}")
    return printed


def run_conformance_tests() -> Recorder:
    """Collect the conformance tests, and run some of the new declarations."""
    recorder = Recorder()
    chosen = " or ".join(f"({text})" for text in CHOSEN)
    code = pytest.main(["-q", "-p", "no:cacheprovider", *FILES, "-k", chosen], plugins=[recorder])
    if code != pytest.ExitCode.OK:
        raise RuntimeError(f"the conformance tests ended with {code!r}")
    return recorder


def main() -> None:
    """Write everything below the folder that the command line names."""
    folder = Path(sys.argv[1])
    printed = run_commands(folder)
    generate_pages()
    recorder = run_conformance_tests()
    report = {
        "package": prp_gym.__file__,
        "printed": printed,
        "collected": recorder.collected,
        "passed": recorder.passed,
    }
    (folder / "trial.json").write_text(json.dumps(report), encoding="utf-8")


if __name__ == "__main__":
    main()
