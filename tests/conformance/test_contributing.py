"""CONTRIBUTING names every folder, and its recipes, followed literally, are enough for a new declaration."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.conformance.test_dependency_rule import CORE_PACKAGES, MAY_IMPORT
from tests.support.contributions import (
    ACTION_MODE,
    ALGORITHM,
    CONTRIBUTIONS,
    CONTROLLER,
    METRIC,
    TASK,
    Contribution,
    add,
    copy_tracked_files,
)

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


def named_folders() -> set[str]:
    """Folders in the first column of the table."""
    rows = [line.split("|")[1] for line in TEXT.splitlines() if line.startswith("| `")]
    return {name for cell in rows for name in re.findall(r"`([^`]+)/`", cell)}


def folders_of_code() -> set[str]:
    """Folders that hold tracked Python files, tests and examples as one."""
    listed = subprocess.run(["git", "ls-files", "*.py"], cwd=ROOT, capture_output=True, text=True, check=True)
    folders = {str(Path(name).parent) for name in listed.stdout.splitlines()}
    return {re.sub(r"^(tests|examples)/.*", r"\1", folder) for folder in folders}


def test_every_folder_of_code_is_named() -> None:
    unnamed = folders_of_code() - named_folders()
    assert unnamed <= {"agents", "."}  # an empty package around its parts; the build script of the package


def test_named_folders_exist() -> None:
    assert [name for name in named_folders() if not (ROOT / name).is_dir() and name != "examples"] == []


def test_who_may_import_whom_is_the_table_that_is_enforced() -> None:
    section = TEXT.split("Who may import whom")[1].split("\nA new sub-package")[0]
    core, _, table = section.partition("| package |")
    named = [re.findall(r"`(\w+)`", line) for line in table.splitlines() if line.startswith("| `")]
    listed = {package: set(imported) for package, *imported in named}
    everything = set(MAY_IMPORT) - {"cli"}
    assert listed | {"cli": everything} == {package: set(names) for package, names in MAY_IMPORT.items()}
    assert "| `cli` | all of them |" in table
    assert set(CORE_PACKAGES) <= set(re.findall(r"`(\w+)`", core))


def test_named_declarations_exist() -> None:
    import prp_gym

    for name in set(re.findall(r"`(register_\w+)\b", TEXT)):
        assert callable(getattr(prp_gym, name))


def test_named_files_exist() -> None:
    paths = set(re.findall(r"`([a-z_]+/[a-z_/]*[a-z_]+\.(?:py|toml|yml))`", TEXT))
    assert paths
    assert [path for path in paths if not (ROOT / path).exists()] == []


@pytest.mark.parametrize("contribution", CONTRIBUTIONS, ids=lambda each: each.name)
def test_contribution_consists_of_the_files_that_its_recipe_names(contribution: Contribution) -> None:
    recipe = TEXT.split(f"### {contribution.recipe}\n")[1].split("\n### ")[0]
    named = set(re.findall(rf"`{contribution.folder}/<\w+>(\.\w+)`", recipe))
    assert {Path(name).suffix for name in contribution.files} == named
    assert ".py" in named
    assert len(named) == len(contribution.files) <= 2


def test_contributions_are_picked_up_by_every_command_page_and_conformance_test(tmp_path: Path) -> None:
    tree, output = tmp_path / "tree", tmp_path / "output"
    tracked = copy_tracked_files(tree)
    for contribution in CONTRIBUTIONS:
        add(contribution, tree)
    output.mkdir()
    report = run_trial(tree, output)
    assert Path(report["package"]) == tree / "prp_gym" / "__init__.py"
    check_that_nothing_else_was_changed(tree, tracked)
    check_lists(report["printed"])
    check_evaluation(output / "results", report["printed"]["evaluate"])
    check_comparison(output / "comparison", report["printed"]["compare"])
    check_tuning(output / "tuning")
    check_training(output / "runs")
    check_pages(tree / "docs")
    check_conformance_tests(report["collected"], report["passed"])


def run_trial(tree: Path, output: Path) -> dict[str, Any]:
    """What the commands print in the tree, and which conformance tests it has."""
    variables = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    program = [sys.executable, "-m", "tests.support.contributions.trial", str(output)]
    done = subprocess.run(
        program,
        cwd=tree,
        env={**variables, "PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return read(output / "trial.json")


def read(path: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return content


def rows(text: str) -> Iterator[list[str]]:
    """Words of the lines of printed tables."""
    yield from (line.split() for line in text.splitlines() if line.strip())


def check_that_nothing_else_was_changed(tree: Path, tracked: list[str]) -> None:
    from docs.generate import PAGES

    pages = {f"docs/{name}" for name in PAGES}
    files = {str(path.relative_to(tree)) for path in tree.rglob("*") if path.is_file() or path.is_symlink()}
    added = {path for contribution in CONTRIBUTIONS for path in contribution.paths}
    assert files == {*tracked, *added}
    for path in set(tracked) - pages:
        if not (ROOT / path).is_dir():
            assert (tree / path).read_bytes() == (ROOT / path).read_bytes(), path


def check_lists(printed: dict[str, str]) -> None:
    words = set(printed["list"].split())
    assert {TASK.name, CONTROLLER.name, "sine"} <= words
    matrix = list(rows(printed["list_matrix"]))
    short = TASK.name.removeprefix("PRP-").removesuffix("-v0")
    assert [row[-1] for row in matrix if row[0] == short][
        -1
    ] == "yes"  # the last column is the new controller's
    assert any("feedforward" in row for row in matrix)
    assert [row[1] for row in rows(printed["list_modes"]) if row[0] == ACTION_MODE.name] == [CONTROLLER.name]
    algorithms = {row[0]: row[-1] for row in rows(printed["list_algorithms"])}
    assert algorithms[ALGORITHM.name] == "stable_baselines3.A2C"
    metrics = {row[0]: row[1] for row in rows(printed["list_metrics"]) if len(row) > 1}
    assert metrics[METRIC.name] == "W"
    assert f"Learning algorithm: {ALGORITHM.name}, " in printed["help_train"]


def check_evaluation(folder: Path, printed: str) -> None:
    found = {row["baseline"]: row for row in read(folder / "results.json")["evaluations"]}
    assert set(found) == {CONTROLLER.name, "joint_pd", "zero_torque", "hold"}
    assert {row["environment"] for row in found.values()} == {TASK.name}
    assert found["joint_pd"]["score"]["value"] < found[CONTROLLER.name]["score"]["value"] < 1.0
    assert found[CONTROLLER.name]["settings"]["proportional_gain"] == [563.0, 2480.0, 25.2]
    for name in (CONTROLLER.name, "joint_pd"):
        row = found[name]
        (peak,), (energy,) = row["median"][METRIC.name], row["median"]["energy"]
        assert peak > energy / row["duration"] > 0.0  # the largest power exceeds the mean
    assert {"peak", "power"} <= set(printed.split())  # a heading in lines
    assert f"{TASK.name}, scenario report" in printed


def check_comparison(folder: Path, printed: str) -> None:
    content = read(folder / "results.json")
    kinds = [(row["policy"], row["kind"]) for row in content["evaluations"]]
    classical = [(CONTROLLER.name, "controller"), ("joint_pd", "controller")]
    assert kinds == [*classical, ("zero_torque", "floor"), ("hold", "floor")]
    assert content["evaluations"][2]["median"][METRIC.name] == [0.0]
    assert f"{TASK.name}, scenario report" in printed


def check_tuning(folder: Path) -> None:
    found = folder / f"{TASK.name}_{CONTROLLER.name}"
    result = read(found / "result.json")
    assert (result["environment"], result["controller"], result["trials"]) == (TASK.name, CONTROLLER.name, 2)
    assert result["score"] >= result["score_of_start"] > 0.9
    assert "bandwidth_joint_3" in (found / "study.log").read_text(encoding="utf-8")


def check_training(folder: Path) -> None:
    run = folder / TASK.name / f"{ALGORITHM.name}_{ACTION_MODE.name}" / "seed_0"
    assert read(run / "result.json")["algorithm"] == ALGORITHM.name
    card = read(run / "agent.json")["card"]
    assert card["algorithm"] == "A2C"
    assert card["interface"]["environment_id"] == TASK.name
    assert card["interface"]["keywords"]["action_mode"] == ACTION_MODE.name


def check_pages(folder: Path) -> None:
    def sections(page: str, level: str) -> dict[str, str]:
        """Texts of a page's sections by their headings."""
        parts = (folder / page).read_text(encoding="utf-8").split(f"\n{level} ")[1:]
        return {part.splitlines()[0]: part for part in parts}

    sheet = sections("environments.md", "##")[TASK.name]
    assert "Follow a sine in every joint." in sheet
    assert f"`{CONTROLLER.name}`" in sheet.split("Controllers that run on this task")[1]
    assert f"`{ACTION_MODE.name}`" in sheet.split("Action modes: ")[1]
    assert "feedforward of the inverse dynamics" in sections("baselines.md", "#")["Baselines"]
    assert "proportional_gain 563, 2480, 25.2" in sections("baselines.md", "##")[CONTROLLER.name]
    assert "±(0.1, 0.02, 0.1)" in sections("action_modes.md", "###")[ACTION_MODE.name]
    metrics = sections("metrics.md", "##")
    assert f"| `{METRIC.name}` | W |" in metrics["Power"]
    for criterion in ("response_settling_time", "unsettled", "overshoot"):  # those of the joint tasks
        assert f"| `{TASK.name}` | `{criterion}` |" in metrics["Criteria of the audit"]
    assert f"Learning algorithm: {ALGORITHM.name}, " in sections("command_line.md", "##")["prp-gym train"]


def check_conformance_tests(collected: list[str], passed: list[str]) -> None:
    for contribution, least in ((TASK, 10), (CONTROLLER, 2), (ACTION_MODE, 2), (ALGORITHM, 1)):
        cases = {case for case in collected if contribution.name in case}
        assert len({case.split("[")[0] for case in cases}) >= least
        assert cases & set(passed)
