"""Files of finished pairs: reused by what made them alone, and never believed when damaged."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from prp_gym import finished_pairs
from prp_gym.finished_pairs import FinishedPairs, source_digest
from prp_gym.pairs import Pair

PAIR = Pair("PRP-JointTracking-v0", "randomized", "joint_pd", "tuned_50hz", 50.0, 2, 7)
OTHER = replace(PAIR, law="adaptive")
RECORD = {"score": {"value": 1 / 3, "low": 0.1, "high": 0.5}, "median": {"settling_time": ["inf", None]}}


def only_file(folder: Path) -> Path:
    (path,) = folder.iterdir()
    return path


def test_kept_record_is_found_again_as_it_was(tmp_path: Path) -> None:
    FinishedPairs(tmp_path / "pairs").keep(PAIR, RECORD)
    assert FinishedPairs(tmp_path / "pairs").find([PAIR, OTHER]) == ({PAIR: RECORD}, [])
    assert only_file(tmp_path / "pairs").name == "PRP-JointTracking-v0_randomized_joint_pd.json"


def test_nothing_is_found_where_nothing_is(tmp_path: Path) -> None:
    assert FinishedPairs(tmp_path / "pairs").find([PAIR]) == ({}, [])
    assert list(tmp_path.iterdir()) == []


CHANGES: list[dict[str, Any]] = [
    {"gains": "report"},
    {"control_frequency": 100.0},
    {"episodes": 3},
    {"seed": 8},
]


@pytest.mark.parametrize("change", CHANGES, ids=str)
def test_record_of_other_settings_is_not_reused(tmp_path: Path, change: dict[str, Any]) -> None:
    finished = FinishedPairs(tmp_path)
    finished.keep(PAIR, RECORD)
    assert finished.find([replace(PAIR, **change)]) == ({}, [only_file(tmp_path)])


STRANGERS = [OTHER, replace(PAIR, scenario="report"), replace(PAIR, environment_id="PRP-Adaptive-v0")]


@pytest.mark.parametrize("stranger", STRANGERS, ids=str)
def test_file_under_another_pairs_name_is_not_reused(tmp_path: Path, stranger: Pair) -> None:
    finished = FinishedPairs(tmp_path)
    finished.keep(stranger, RECORD)
    path = only_file(tmp_path).rename(tmp_path / f"{PAIR.name}.json")
    assert finished.find([PAIR]) == ({}, [path])


@pytest.mark.parametrize(("name", "value"), [("source_digest", "0" * 64), ("list_versions", {"numpy": "1"})])
def test_record_of_other_code_or_versions_is_not_reused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, value: Any
) -> None:
    finished = FinishedPairs(tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(finished_pairs, name, lambda: value)
        finished.keep(PAIR, RECORD)
        assert finished.find([PAIR]) == ({PAIR: RECORD}, [])
    assert finished.find([PAIR]) == ({}, [only_file(tmp_path)])


def other_number(text: bytes) -> bytes:
    content = json.loads(text)
    content["record"]["score"]["low"] = 0.2
    return json.dumps(content).encode()


def without_record(text: bytes) -> bytes:
    return json.dumps({"key": json.loads(text)["key"]}).encode()


DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "empty": lambda _: b"",
    "truncated": lambda text: text[: len(text) // 2],
    "number": other_number,
    "no record": without_record,
    "not a mapping": lambda _: b"[1, 2]",
    "number alone": lambda _: b"3",
    "not text": lambda _: b"\xff\xfe\x00\x01",
    "endless": lambda _: b"[" * 100_000,
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_or_foreign_file_is_not_reused(tmp_path: Path, damage: str) -> None:
    finished = FinishedPairs(tmp_path)
    finished.keep(PAIR, RECORD)
    path = only_file(tmp_path)
    path.write_bytes(DAMAGES[damage](path.read_bytes()))
    assert finished.find([PAIR]) == ({}, [path])
    finished.keep(PAIR, RECORD)
    assert finished.find([PAIR]) == ({PAIR: RECORD}, [])


def test_folder_in_the_place_of_a_file_is_not_reused(tmp_path: Path) -> None:
    place = tmp_path / f"{PAIR.name}.json"
    place.mkdir()
    assert FinishedPairs(tmp_path).find([PAIR]) == ({}, [place])


def test_files_are_removed_with_what_a_kill_left_half_written(tmp_path: Path) -> None:
    finished = FinishedPairs(tmp_path / "pairs")
    for pair in (PAIR, OTHER):
        finished.keep(pair, RECORD)
    (tmp_path / "pairs" / f".{PAIR.name}.json.123.part").write_text("{")
    finished.remove([PAIR])
    assert only_file(tmp_path / "pairs").stem == OTHER.name
    finished.remove([PAIR, OTHER])
    assert list(tmp_path.iterdir()) == []


def test_what_is_somebody_elses_stays(tmp_path: Path) -> None:
    finished = FinishedPairs(tmp_path / "pairs")
    finished.keep(PAIR, RECORD)
    mine = tmp_path / "pairs" / "mine.json"
    mine.write_text("mine")
    finished.remove([PAIR])
    assert only_file(tmp_path / "pairs") == mine


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package of a module, a data file and something else, as the one whose digest is taken."""
    (tmp_path / "inner").mkdir()
    for name in ("__init__.py", "inner/data.toml", "notes.txt"):
        (tmp_path / name).write_text("x = 1")
    made = SimpleNamespace(__name__="package", __file__=str(tmp_path / "__init__.py"))
    monkeypatch.setattr(finished_pairs, "_SOURCES", (made,))
    return tmp_path


@pytest.mark.parametrize("name", ["__init__.py", "inner/data.toml", "new.py"])
def test_digest_changes_with_code_and_data(package: Path, name: str) -> None:
    before = source_digest.__wrapped__()
    assert source_digest.__wrapped__() == before
    (package / name).write_text("x = 2")
    assert source_digest.__wrapped__() != before


def test_digest_changes_with_a_files_name_and_not_with_other_files(package: Path) -> None:
    before = source_digest.__wrapped__()
    (package / "notes.txt").write_text("y")
    assert source_digest.__wrapped__() == before
    (package / "inner" / "data.toml").rename(package / "inner" / "other.toml")
    assert source_digest.__wrapped__() != before


def test_digest_is_over_every_part_that_a_result_depends_on() -> None:
    folders = {Path(source.__file__ or "").resolve().parent for source in finished_pairs._SOURCES}
    assert {folder.name for folder in folders} == {"prp_gym", "envs", "baselines"}
