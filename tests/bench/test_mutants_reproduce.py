"""The deliberate defects of `make mutants-reproduce`: each can be put into the tree and names its runs."""

from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from bench import judge_runs, mutants_reproduce
from bench.mutants import BROKEN, LATE, NOTICED, SURVIVED, Defect, Outcome, locate
from bench.mutants_reproduce import ReachableDefect
from prp_gym.reproduction import load_catalogue

ITEMS = mutants_reproduce.load_reachable()
LEAST = 60
RUNS = load_catalogue().runs
JUDGE = '''"""Says what a number of the tree makes of the runs."""

import sys

from own.numbers import FOUR

print(sys.argv[1:], FOUR)
sys.exit(FOUR != 4)
'''


def test_there_are_enough_defects_and_every_controller_has_some() -> None:
    assert len(ITEMS) >= LEAST
    assert {RUNS[run].controller for item in ITEMS for run in item.runs} == {
        run.controller for run in RUNS.values()
    }
    assert len({(item.defect.old, item.defect.new) for item in ITEMS}) == len(ITEMS)


@pytest.mark.parametrize("item", ITEMS, ids=lambda item: item.name)
def test_old_text_stands_once_and_the_runs_exist(item: ReachableDefect) -> None:
    file = locate(item.defect)
    changed = file.read_text(encoding="utf-8").replace(item.defect.old, item.defect.new)
    assert changed != file.read_text(encoding="utf-8")
    if file.suffix == ".py":
        compile(changed, str(file), "exec")
    assert item.runs
    assert set(item.runs) <= set(RUNS)


def tree_of(folder: Path) -> Path:
    """A tree whose judge looks at one number."""
    for name in ("own", "bench"):
        (folder / name).mkdir()
        (folder / name / "__init__.py").write_text("", encoding="utf-8")
    (folder / "own" / "numbers.py").write_text("TWO = 2\nFOUR = 2 * TWO\n", encoding="utf-8")
    (folder / "bench" / "judge_runs.py").write_text(JUDGE, encoding="utf-8")
    return folder


@pytest.mark.parametrize(
    ("old", "new", "result"),
    [("FOUR = 2", "FOUR = 3", NOTICED), ("2 * TWO", "TWO * 2", SURVIVED), ("TWO = 2", "TWO =", BROKEN)],
)
def test_defect_is_noticed_where_a_check_fails_and_the_tree_is_left_as_it_was(
    tmp_path: Path, old: str, new: str, result: str
) -> None:
    tree = tree_of(tmp_path)
    before = (tree / "own" / "numbers.py").read_text(encoding="utf-8")
    outcome = mutants_reproduce.try_reachable(
        ReachableDefect(Defect("wrong", "own", old, new, ()), ("a", "b")), tree
    )
    assert (outcome.name, outcome.result) == ("wrong", result)
    if result == NOTICED:
        assert outcome.witness == "['a', 'b'] 6"
    assert (tree / "own" / "numbers.py").read_text(encoding="utf-8") == before


def test_runs_that_do_not_end_are_given_up(tmp_path: Path) -> None:
    tree = tree_of(tmp_path)
    (tree / "bench" / "judge_runs.py").write_text("import time\ntime.sleep(60)\n", encoding="utf-8")
    code, witness = mutants_reproduce.judge_tree(tree, ["a"], limit=0.5)
    assert (code, witness) == (None, "more than 0.5 s")
    assert LATE not in (NOTICED, SURVIVED)


@pytest.mark.parametrize(("noticed", "code"), [(19, 0), (18, 1)])
def test_exit_code_says_whether_the_goal_is_reached(
    monkeypatch: pytest.MonkeyPatch, noticed: int, code: int
) -> None:
    def tried(items: list[ReachableDefect], *_: object) -> list[Outcome]:
        results = [NOTICED] * noticed + [SURVIVED] * (20 - noticed)
        return [Outcome(item.name, result, 1.0, "") for item, result in zip(items, results, strict=True)]

    monkeypatch.setattr(mutants_reproduce, "load_reachable", lambda: ITEMS[:20])
    monkeypatch.setattr(mutants_reproduce, "_try_in_a_copy", tried)
    found = CliRunner().invoke(mutants_reproduce.app, [])
    assert found.exit_code == code
    assert f"{noticed} of 20 defects noticed" in found.stdout


def test_judge_finds_nothing_in_the_tree_as_it_is() -> None:
    assert judge_runs.first_failure(["force_estimated"]) == ""


def test_judge_names_the_check_that_fails_first(monkeypatch: pytest.MonkeyPatch) -> None:
    item = load_catalogue()
    slower = replace(item.runs["pd_sine"], overrides={"derivative_gain": 15.0})
    runs = {**item.runs, "pd_sine": slower}
    monkeypatch.setattr(judge_runs, "load_catalogue", lambda: replace(item, runs=runs))
    assert judge_runs.first_failure(["pd_sine"]).startswith("sine_error: [")
