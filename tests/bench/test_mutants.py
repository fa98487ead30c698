"""The deliberate defects of `make mutants`: each can be put into the tree, and takes effect."""

from pathlib import Path

import pytest
from rich.console import Console
from typer.testing import CliRunner

from bench import mutants
from bench.mutants import BROKEN, LATE, NOTICED, ROOT, SURVIVED, Defect, Outcome
from prp_gym.errors import InvalidValueError, UnknownNameError

DEFECTS = mutants.load_defects()
LEAST = 43


def test_there_are_enough_defects_and_every_part_has_some() -> None:
    assert len(DEFECTS) >= LEAST
    parts = {defect.package.split(".")[1] for defect in DEFECTS}
    named = {"robot", "physics", "envs", "tasks", "baselines", "evaluation", "comparison", "agents"}
    assert named <= parts
    assert len({(defect.old, defect.new) for defect in DEFECTS}) == len(DEFECTS)


@pytest.mark.parametrize("defect", DEFECTS, ids=lambda defect: defect.name)
def test_old_text_stands_once_and_declared_tests_exist(defect: Defect) -> None:
    file = mutants.locate(defect)
    changed = file.read_text(encoding="utf-8").replace(defect.old, defect.new)
    assert changed != file.read_text(encoding="utf-8")
    if file.suffix == ".py":
        compile(changed, str(file), "exec")
    assert defect.tests
    assert all((ROOT / test).is_file() for test in defect.tests)


def tree_of(folder: Path, value: str = "2") -> Path:
    """A package of one number, and a test of it."""
    (folder / "own").mkdir()
    (folder / "own" / "__init__.py").write_text("", encoding="utf-8")
    (folder / "own" / "numbers.py").write_text(f"TWO = {value}\nFOUR = 2 * TWO\n", encoding="utf-8")
    (folder / "test_own.py").write_text(
        "from own.numbers import FOUR\n\n\ndef test_four():\n    assert FOUR == 4\n", encoding="utf-8"
    )
    return folder


def defect(old: str, new: str, package: str = "own") -> Defect:
    return Defect("wrong", package, old, new, ("test_own.py",))


@pytest.mark.parametrize(
    ("old", "new", "result"),
    [("FOUR = 2", "FOUR = 3", NOTICED), ("2 * TWO", "TWO * 2", SURVIVED), ("TWO = 2", "TWO =", BROKEN)],
)
def test_defect_is_noticed_where_a_test_fails_and_the_tree_is_left_as_it_was(
    tmp_path: Path, old: str, new: str, result: str
) -> None:
    tree = tree_of(tmp_path)
    before = (tree / "own" / "numbers.py").read_text(encoding="utf-8")
    outcome = mutants.try_defect(defect(old, new), tree)
    assert outcome.result == result, outcome
    assert ("test_four" in outcome.witness) == (result == NOTICED)
    assert (tree / "own" / "numbers.py").read_text(encoding="utf-8") == before


def test_tests_past_the_limit_of_time_notice_nothing(tmp_path: Path) -> None:
    code, witness = mutants.run_tests(tree_of(tmp_path), ("test_own.py",), limit=0.01)
    assert code is None
    assert "0.01 s" in witness


def test_tree_in_which_a_test_fails_anyway_is_refused(tmp_path: Path) -> None:
    tree = tree_of(tmp_path, value="3")
    with pytest.raises(InvalidValueError, match=r"tests without a defect is .*test_four.*allowed: all pass"):
        mutants.check_tree(tree, [defect("FOUR = 2", "FOUR = 3")])


@pytest.mark.parametrize(("old", "count"), [("TWO", 2), ("THREE", 0)])
def test_old_text_that_does_not_stand_once_is_refused(tmp_path: Path, old: str, count: int) -> None:
    with pytest.raises(InvalidValueError, match=f"defect 'wrong' is {count}; allowed: 1"):
        mutants.locate(defect(old, "1"), tree_of(tmp_path))


def test_defect_is_located_by_its_module_as_well_as_by_its_package(tmp_path: Path) -> None:
    tree = tree_of(tmp_path)
    for package in ("own", "own.numbers"):
        assert mutants.locate(defect("FOUR", "FIVE", package), tree) == tree / "own" / "numbers.py"


def test_copy_holds_the_linked_packages_and_is_apart_from_the_tree(tmp_path: Path) -> None:
    copy = mutants.copy_tree(tmp_path / "copy")
    found = mutants.locate(DEFECTS[0], copy)
    assert found.is_relative_to(copy)
    for part in ("envs", "baselines", "agents"):
        assert (copy / "prp_gym" / part).resolve() == (copy / part).resolve()


def test_only_the_named_defects_are_tried() -> None:
    name = DEFECTS[3].name
    assert mutants.choose(DEFECTS, [name]) == [DEFECTS[3]]
    assert mutants.choose(DEFECTS, []) == DEFECTS
    with pytest.raises(UnknownNameError, match=f"Did you mean '{name}'"):
        mutants.choose(DEFECTS, [name[:-1]])


@pytest.mark.parametrize(("result", "code"), [(NOTICED, 0), (SURVIVED, 1), (BROKEN, 1), (LATE, 1)])
def test_command_fails_where_a_defect_is_not_noticed(
    monkeypatch: pytest.MonkeyPatch, result: str, code: int
) -> None:
    def tried(defects: list[Defect], *_: object) -> list[Outcome]:
        return [Outcome(each.name, result, 1.0, "FAILED tests/own.py::test - wrong") for each in defects]

    monkeypatch.setattr(mutants, "_try_in_copies", tried)
    outcome = CliRunner().invoke(mutants.app, ["--only", DEFECTS[0].name])
    assert outcome.exit_code == code, outcome.output
    assert f"{int(code == 0)} of 1 defects noticed" in outcome.output
    assert "own.py::test" in outcome.output


def test_outcomes_keep_the_order_of_the_defects(tmp_path: Path) -> None:
    folders = [tmp_path / "a", tmp_path / "b"]
    for folder in folders:
        folder.mkdir()
    defects = [defect("FOUR = 2", f"FOUR = {factor}") for factor in ("3", "1 * 2", "5")]
    outcomes = mutants.try_all(defects, [tree_of(folder) for folder in folders], Console(quiet=True))
    assert [outcome.result for outcome in outcomes] == [NOTICED, SURVIVED, NOTICED]
