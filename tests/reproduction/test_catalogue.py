"""The files of the report's experiments are refused where they do not hold together."""

import json
import tomllib
from copy import deepcopy
from importlib.resources import files
from typing import Any

import pytest

from prp_gym.errors import InvalidValueError, PRPError, UnknownNameError
from prp_gym.reproduction import Catalogue
from prp_gym.reproduction.catalogue import read_catalogue

CHAPTER = files("prp_gym.reproduction").joinpath("joint_pd.toml").read_text(encoding="utf-8")
TABLES = tomllib.loads(CHAPTER)
FROZEN = "predict = { value = [2.0143248e-08"
FORMULA = 'predict = { name = "slowest_force_mode" }\nlabel = "a"#'


def changed(old: str, new: str) -> Catalogue:
    """The first chapter with a piece of its text replaced."""
    assert CHAPTER.count(old) >= 1
    return read_catalogue([CHAPTER.replace(old, new, 1)])


@pytest.mark.parametrize(
    ("old", "new", "error", "words"),
    [
        ('run = "pd", signal', 'run = "dp", signal', UnknownNameError, ["run", "dp", "pd_sine"]),
        ('name = "final_value"', 'name = "last"', UnknownNameError, ["measurement", "last", "final_value"]),
        (FROZEN, FORMULA.replace("slow", "slo"), UnknownNameError, ["formula", "slowest_force_mode"]),
        ('signal = "joint_error" }', 'signal = "error" }', UnknownNameError, ["signal", "joint_error"]),
        ("components = [0, 1, 2]", "components = [0, 3]", UnknownNameError, ["component", "'3'"]),
        ('runs = ["pd", "pd_printed"]', 'runs = ["pdd"]', UnknownNameError, ["run", "pdd"]),
        ("after = 2.0", "from = 2.0", UnknownNameError, ["argument", "from", "sine_error", "after"]),
        (FROZEN, FORMULA, InvalidValueError, ["slowest_force_mode", "force_gain"]),
        ("until = 3.0", "till = 3.0", UnknownNameError, ["key of figure 5", "till", "until"]),
        ("until = 3.0\n", "", InvalidValueError, ["until", "figure 5", "missing"]),
        ("duration = 5.0\n", "", InvalidValueError, ["duration", "run 'pd'", "missing"]),
        ("number = 6", "number = 5", InvalidValueError, ["figure 5", "twice"]),
        ('name = "pd_settling"', 'name = "pd_error"', InvalidValueError, ["pd_error", "twice"]),
        ("{pd_sag[2]:.5f}", "{pd_sagg[2]:.5f}", UnknownNameError, ["answer to 6.2", "pd_sagg", "pd_sag"]),
        ('predictions = ["pd_sag"]', 'predictions = ["pd_error"]', UnknownNameError, ["pd_error", "pd_sag"]),
        ("absolute = 1e-4", "absolute = 0.0", InvalidValueError, ["tolerance", "pd_error", "above 0"]),
        (
            "absolute = 1e-4",
            'absolute = 1e-4\nexplanation = "x"',
            InvalidValueError,
            ["explained_tolerance", "pd_error"],
        ),
        (
            'label = "with g(q), gains as printed"',
            'label = "reference"',
            InvalidValueError,
            ["label", "twice"],
        ),
        (
            'gains = "report"\nduration = 5.0',
            'gains = "report"\nduration = 5.0\ncontrol_frequency = 500.0',
            InvalidValueError,
            ["control frequencies", "figure 5", "500.0"],
        ),
    ],
)
def test_data_that_does_not_hold_together_is_refused(
    old: str, new: str, error: type[PRPError], words: list[str]
) -> None:
    with pytest.raises(error) as caught:
        changed(old, new)
    assert [word for word in words if word not in str(caught.value)] == []


def without(key: str, *path: str | int) -> str:
    """The first chapter without a key of one of its tables."""
    tables = deepcopy(TABLES)
    table: Any = tables
    for step in path:
        table = table[step]
    del table[key]
    return as_toml(tables)


def as_toml(value: Any) -> str:
    """Tables written as inline TOML, one key a line."""
    return "\n".join(f"{json.dumps(key)} = {_inline(item)}" for key, item in value.items())


def _inline(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {_inline(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_inline, value)) + "]"
    return json.dumps(value)


def test_chapter_written_anew_is_the_same() -> None:
    assert tomllib.loads(as_toml(TABLES)) == TABLES
    read_catalogue([as_toml(TABLES)])


@pytest.mark.parametrize(
    ("key", "path", "words"),
    [
        ("runs", (), "a chapter"),
        ("figures", (), "a chapter"),
        ("answers", (), "a chapter"),
        ("checks", ("figures", 0), "figure 5"),
        ("panels", ("figures", 0), "figure 5"),
        ("title", ("figures", 0), "figure 5"),
        ("runs", ("figures", 0, "panels", 0), "panel of figure 5"),
        ("components", ("figures", 0, "panels", 0), "panel of figure 5"),
        ("measure", ("figures", 0, "checks", 0), "check 'pd_error' of figure 5"),
        ("predict", ("figures", 0, "checks", 0), "check 'pd_error' of figure 5"),
        ("name", ("figures", 0, "checks", 0), "check None of figure 5"),
        ("text", ("answers", 0), "answer"),
        ("controller", ("runs", "pd"), "run 'pd'"),
    ],
)
def test_key_that_is_missing_is_named(key: str, path: tuple[str | int, ...], words: str) -> None:
    with pytest.raises(InvalidValueError) as caught:
        read_catalogue([without(key, *path)])
    assert str(caught.value) == f"key {key!r} of {words} is 'missing'; allowed: present."


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("runs = 3", "'runs'"),
        ("runs = {a = 3}", "run 'a'"),
        ("runs = {}\nfigures = 3", "'figures'"),
        ("runs = {}\nfigures = [3]", "'figures'"),
    ],
)
def test_value_of_another_kind_is_refused(text: str, words: str) -> None:
    with pytest.raises(InvalidValueError, match=words):
        read_catalogue([text])


def later(**changes: Any) -> str:
    """A chapter with one further check, of figure 5 unless it is changed."""
    check = {**TABLES["figures"][0]["checks"][0], "figure": 5, "name": "later", **changes}
    return as_toml({"runs": {}, "figures": [], "answers": [], "checks": [check]})


def test_later_chapter_adds_its_checks_to_their_figures() -> None:
    plain, more = (read_catalogue([CHAPTER, *texts]) for texts in ([], [later()]))
    names = [check.name for check in plain.experiments[5].checks]
    assert [check.name for check in more.experiments[5].checks] == [*names, "later"]
    assert len(more.experiments[6].checks) == len(plain.experiments[6].checks)


@pytest.mark.parametrize(
    ("changes", "error", "words"),
    [
        ({"figure": 9}, UnknownNameError, ["unknown figure"]),
        ({"name": "pd_error"}, InvalidValueError, ["pd_error", "twice"]),
    ],
)
def test_later_check_that_fits_no_figure_is_refused(
    changes: dict[str, Any], error: type[PRPError], words: list[str]
) -> None:
    with pytest.raises(error) as caught:
        read_catalogue([CHAPTER, later(**changes)])
    assert [word for word in words if word not in str(caught.value)] == []


def test_two_predictions_of_one_figure_need_two_labels() -> None:
    tables = deepcopy(TABLES)
    sag, panel = tables["figures"][1]["checks"][0], tables["figures"][1]["panels"][1]
    tables["figures"][1]["checks"].append({**sag, "name": "again"})
    panel["predictions"] = ["pd_sag", "again"]
    with pytest.raises(InvalidValueError, match="label of a prediction in figure 6 'predicted'"):
        read_catalogue([as_toml(tables)])
    tables["figures"][1]["checks"][-1]["label"] = "again, predicted"
    read_catalogue([as_toml(tables)])


def test_run_that_two_chapters_define_is_refused() -> None:
    again = "figures = []\nanswers = []\n" + as_toml({"runs": {"pd": TABLES["runs"]["pd"]}})
    with pytest.raises(InvalidValueError, match="run 'pd' is 'given twice'"):
        read_catalogue([CHAPTER, again])


def with_runs(*labels: str) -> str:
    """The first chapter with runs of these labels drawn in figure 5, in two panels."""
    tables = deepcopy(TABLES)
    names = [f"run_{index}" for index in range(len(labels))]
    for name, label in zip(names, labels, strict=True):
        tables["runs"][name] = {**tables["runs"]["pd"], "label": label}
    panel = tables["figures"][0]["panels"][0]
    tables["figures"][0]["panels"] = [{**panel, "runs": names[:2]}, {**panel, "runs": names[1:]}]
    return as_toml(tables)


@pytest.mark.parametrize(
    ("labels", "words"),
    [
        ("abcde", "number of runs drawn in figure 5 is 5; allowed: at most 4"),
        ("abb", "label in figure 5 'b' is 'given twice'"),
    ],
)
def test_runs_that_one_figure_cannot_show_are_refused(labels: str, words: str) -> None:
    with pytest.raises(InvalidValueError) as caught:
        read_catalogue([with_runs(*labels)])
    assert words in str(caught.value)


def test_figure_may_show_as_many_runs_as_there_are_colours() -> None:
    panels = read_catalogue([with_runs(*"abcd")]).experiments[5].panels
    assert {name for panel in panels for name in panel.runs} == {"run_0", "run_1", "run_2", "run_3"}
