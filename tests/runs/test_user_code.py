"""Controllers of a user's own: every form runs, faults are reported with a line, only a digest is stored."""

import hashlib
import json
import pickle
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from typer.testing import CliRunner

from prp_gym.baselines import make_baseline
from prp_gym.baselines.floors import FLOORS
from prp_gym.cli.main import app
from prp_gym.errors import GainsFileError, InvalidValueError, PRPError, UnknownNameError, UserCodeError
from prp_gym.evaluation import evaluate
from prp_gym.runs.user_code import UserCode
from prp_gym.tasks.spec import TASKS

RUNNER = CliRunner()
ID = "PRP-JointTracking-v0"
GAINS = {"proportional_gain": [60.0, 600.0, 60.0], "derivative_gain": [15.0, 150.0, 15.0]}

SOURCE = '''
"""Controllers of a test."""

import numpy as np
import prp_gym
from prp_gym.baselines import JointPDController, JointPDSettings


@prp_gym.controller
def function(joint_position, joint_velocity, desired_joint_position, *, stiffness=100.0, damping=10.0):
    return stiffness * (desired_joint_position - joint_position) - damping * joint_velocity


class Subclass(JointPDController):
    """The suite's controller with a name of its own."""


class Constant:
    def __init__(self, interface, level=0.25, note="text"):
        self.joints, self.level = len(interface.torque_limit), level

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        assert observation.ndim == 1
        return np.full(self.joints, self.level), None


class Zero:
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros(3), None


class Refuses(Zero):
    def __init__(self):
        raise RuntimeError("not today")


class Fails(Zero):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return 1 / 0


class FailsLater(Zero):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        if state == 3:
            raise KeyError("state")
        return np.zeros(3), (state or 0) + 1


class NotFinite(Zero):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.full(3, np.nan), None


class Short(Zero):
    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros(2), None


@prp_gym.controller
def short(joint_position):
    return joint_position[..., :2]


@prp_gym.controller
def misspelt(joint_positon):
    return joint_positon


NUMBER = 3
'''


def line_of(text: str) -> int:
    """Number of the line of the source that holds a text."""
    (line,) = (index for index, line in enumerate(SOURCE.splitlines(), 1) if text in line)
    return line


@pytest.fixture(autouse=True)
def mine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A user's file in the current folder, and short episodes."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(gymnasium, "make", partial(gymnasium.make, duration=0.02))
    for name in ("FORCE_COLOR", "TTY_COMPATIBLE", "COLUMNS"):
        monkeypatch.delenv(name, raising=False)
    path = tmp_path / "own" / "mine.py"
    path.parent.mkdir()
    path.write_text(SOURCE, encoding="utf-8")
    return path


def run(command: str, *options: str) -> Any:
    return RUNNER.invoke(app, [command, *options], catch_exceptions=True)


def run_evaluate(name: str, *options: str) -> Any:
    common = ("--env", ID, "--scenario", "randomized", "--episodes", "2", "--jobs", "1", "--output", "out")
    return run("evaluate", *common, "--baseline", name, *options)


def only_record(folder: str = "out") -> dict[str, Any]:
    """The record of the only controller; the floors are evaluated beside it, and no user's code with them."""
    records = json.loads(Path(folder, "results.json").read_text(encoding="utf-8"))["evaluations"]
    (record,) = (record for record in records if not record.get("floor"))
    floors = [other for other in records if other.get("floor")]
    assert [floor["baseline"] for floor in floors] == list(FLOORS)
    assert not any(floor.get("code") for floor in floors)
    return dict(record)


def expected_scores(**settings: Any) -> list[list[float]]:
    env = gymnasium.make(ID, scenario="randomized")
    evaluation = evaluate(make_baseline("joint_pd", env, **settings), env, 2)
    env.close()
    scores: list[list[float]] = evaluation.metrics["score"].tolist()
    return scores


def test_subclass_of_the_suite_s_scores_as_it_does_and_is_recorded_by_digest(mine: Path) -> None:
    Path("gains.toml").write_text("\n".join(f"{name} = {value}" for name, value in GAINS.items()))
    result = run_evaluate("own/mine.py:Subclass", "--gains", "gains.toml")
    assert result.exit_code == 0, result.output
    record = only_record()
    assert record["episodes"]["score"] == expected_scores(**GAINS)
    assert record["baseline"] == "mine.py:Subclass"
    assert record["code"] == {
        "name": "mine.py:Subclass",
        "sha256": hashlib.sha256(mine.read_bytes()).hexdigest(),
    }
    assert record["settings"]["gains"] == "gains.toml"
    assert record["settings"]["proportional_gain"] == GAINS["proportional_gain"]
    assert "mine.py:Subclass" in result.stdout


@pytest.mark.parametrize("options", [(), ("--set", "stiffness=150", "--set", "damping = [8.0, 80.0, 8.0]")])
def test_function_is_evaluated_with_its_settings(options: tuple[str, ...]) -> None:
    result = run_evaluate("own/mine.py:function", *options)
    assert result.exit_code == 0, result.output
    settings = only_record()["settings"]
    expected = (150.0, [8.0, 80.0, 8.0]) if options else (100.0, 10.0)
    assert (settings["stiffness"], settings["damping"]) == expected


def test_class_with_predict_takes_the_interface_and_keyword_settings() -> None:
    result = run_evaluate("own/mine.py:Constant", "--set", "level=0.5")
    assert result.exit_code == 0, result.output
    record = only_record()
    assert record["settings"] == {"gains": "tuned", "level": 0.5, "note": "text"}
    env = gymnasium.make(ID)
    rms = np.array(record["episodes"]["torque_rms"])
    np.testing.assert_allclose(rms, np.tile(0.5 * env.get_wrapper_attr("torque_limit"), (2, 1)), rtol=1e-6)
    env.close()


def test_module_of_the_current_folder_is_named_by_its_import_path(mine: Path) -> None:
    mine.rename("plug_mine_as_module.py")
    result = run_evaluate("plug_mine_as_module:Zero")
    assert result.exit_code == 0, result.output
    assert only_record()["code"]["name"] == "plug_mine_as_module:Zero"
    assert np.abs(only_record()["episodes"]["torque_rms"]).max() == 0.0


FAULTS = [
    ("Refuses", 'RuntimeError("not today")', "RuntimeError: not today"),
    ("Fails", "return 1 / 0", "ZeroDivisionError: division by zero"),
    ("FailsLater", 'KeyError("state")', "KeyError: 'state'"),
    ("NotFinite", "class NotFinite", "PolicyOutputError: predict of NotFinite returned an action with NaN"),
    ("Short", "class Short", r"PolicyOutputError: predict of Short returned an action of shape (2,)"),
    ("short", "@prp_gym.controller", "ShapeError: torques returned by controller function 'short'"),
]


@pytest.mark.parametrize(("name", "text", "reason"), FAULTS)
def test_fault_is_reported_with_the_line_of_the_user_s_file(
    mine: Path, name: str, text: str, reason: str
) -> None:
    error = run_evaluate(f"own/mine.py:{name}").exception
    assert isinstance(error, UserCodeError), error
    line = SOURCE[: SOURCE.index(f"def {name}(")].count("\n") if name == "short" else line_of(text)
    assert (error.file, error.line, error.environment_id) == (str(mine), line, ID)
    assert error.reason.startswith(reason)
    assert str(error).startswith(f"{mine}, line {line}: {reason}")
    assert str(error).endswith(f"(on {ID})")
    assert str(pickle.loads(pickle.dumps(error))) == str(error)
    assert not Path("out", "results.json").exists()


def test_fault_in_a_worker_process_is_reported_alike(mine: Path) -> None:
    error = run_evaluate("own/mine.py:FailsLater", "--scenario", "realistic", "--jobs", "2").exception
    assert isinstance(error, UserCodeError), error
    line = line_of('KeyError("state")')
    assert (error.file, error.line, error.environment_id) == (str(mine), line, ID)
    assert error.reason == "KeyError: 'state'"


@pytest.mark.parametrize(
    ("name", "kind", "message"),
    [
        (
            "own/mine.py:Nothing",
            UserCodeError,
            "does not define 'Nothing'; it defines: .*function, Sub",
        ),
        (
            "own/mine.py:NUMBER",
            UserCodeError,
            "'NUMBER' is int; it must be a ControllerSpec, a function",
        ),
        ("own/none.py:Zero", InvalidValueError, "own/none.py'; allowed: a file that can be read"),
        ("nowhere.at_all:Zero", InvalidValueError, "there is no module 'nowhere'"),
        ("own/mine.py:", InvalidValueError, "path/to/file.py:Name or package.module:Name"),
        ("own/mine.py:misspelt", InvalidValueError, "a controller that runs on the chosen environments"),
    ],
)
def test_what_is_no_controller_is_refused_before_anything_is_written(
    name: str, kind: type[PRPError], message: str
) -> None:
    with pytest.raises(kind, match=message):
        raise run_evaluate(name).exception
    assert not Path("out").exists()


def test_file_that_cannot_be_loaded_is_reported_with_its_line(mine: Path) -> None:
    mine.write_text("import numpy\n\nx = numpy.zeros(-1)\n")
    with pytest.raises(UserCodeError, match=r"mine\.py, line 3: ValueError: negative dimensions"):
        raise run_evaluate("own/mine.py:x").exception
    mine.write_text("def f(:\n")
    with pytest.raises(UserCodeError, match=r"mine\.py, line 1: SyntaxError: invalid syntax"):
        raise run_evaluate("own/mine.py:f").exception


@pytest.mark.parametrize(
    ("options", "kind", "message"),
    [
        (
            ("--set", "stifness=1"),
            UnknownNameError,
            "setting of controller 'function' 'stifness'",
        ),
        (("--set", "stiffness"), InvalidValueError, "--set is 'stiffness'; allowed: a setting and its value"),
        (("--set", "stiffness=a b"), InvalidValueError, "value of --set is 'a b'; allowed: a value in TOML"),
        (("--gains", "none.toml"), GainsFileError, "none.toml"),
        (("--gains", "nothing"), UnknownNameError, "unknown gain set of controller 'function' 'nothing'"),
    ],
)
def test_gains_that_do_not_fit_are_refused(
    options: tuple[str, ...], kind: type[PRPError], message: str
) -> None:
    with pytest.raises(kind, match=message):
        raise run_evaluate("own/mine.py:function", *options).exception


def test_gains_file_that_does_not_fit_names_file_and_controller() -> None:
    Path("gains.toml").write_text("stifness = 3.0\n")
    with pytest.raises(GainsFileError, match=r"gains.toml.*setting of controller 'function' 'stifness'"):
        raise run_evaluate("own/mine.py:function", "--gains", "gains.toml").exception
    Path("gains.toml").write_text("stiffness = = 3.0\n")
    with pytest.raises(GainsFileError, match=r"gains.toml.*cannot be read as TOML"):
        raise run_evaluate("own/mine.py:function", "--gains", "gains.toml").exception


def test_setting_that_one_of_the_chosen_controllers_lacks_is_refused_with_its_name() -> None:
    with pytest.raises(UnknownNameError, match="setting of controller 'joint_pd' 'level'"):
        raise run_evaluate("own/mine.py:Constant", "--baseline", "joint_pd", "--set", "level=0.5").exception


def test_two_files_under_one_name_are_refused(mine: Path, tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text(SOURCE + "\n")
    with pytest.raises(InvalidValueError, match=r"mine.py:Zero'; allowed: one that no other controller"):
        raise run_evaluate("own/mine.py:Zero", "--baseline", "mine.py:Zero").exception


def test_finished_job_is_reused_with_the_same_file_alone(
    mine: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("prp_gym.runs.store.JobStore.remove", lambda *_: None)
    assert run_evaluate("own/mine.py:Zero").stderr.strip() == ""
    texts = [path.read_text(encoding="utf-8") for path in Path("out", "jobs").iterdir()]
    assert len(texts) == 1 + len(FLOORS)
    (text,) = (text for text in texts if "mine.py" in text)
    key = json.loads(text)["key"]
    assert key["job"]["controller"]["sha256"] == hashlib.sha256(mine.read_bytes()).hexdigest()
    assert str(mine.parent) not in text
    assert "own/" not in text
    moved = tmp_path / "elsewhere" / "mine.py"
    moved.parent.mkdir()
    moved.write_bytes(mine.read_bytes())
    assert "3 of 3 jobs were finished" in run_evaluate("elsewhere/mine.py:Zero").stderr
    mine.write_text(SOURCE + "\n")  # the floors' jobs do not depend on it
    assert "2 of 3 jobs were finished" in run_evaluate("own/mine.py:Zero").stderr


def test_file_that_changes_under_way_is_refused(mine: Path) -> None:
    code = UserCode.find("own/mine.py:Zero")
    mine.write_text(SOURCE + "# changed\n")
    with pytest.raises(InvalidValueError, match=r"SHA-256 of 'mine.py' is .* that of when the command began"):
        code.load()


def test_own_controllers_are_compared(
    mine: Path, unwritten_figures: None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("prp_gym.agents.policy.agent_file.TRAINED", tmp_path / "none")
    options = ("--env", ID, "--scenario", "randomized", "--episodes", "3", "--jobs", "2", "--output", "out")
    names = ("--baseline", "own/mine.py:function", "--baseline", "own/mine.py:Constant")
    result = run("compare", *options, *names)
    assert result.exit_code == 0, result.output
    content = json.loads(Path("out", "results.json").read_text(encoding="utf-8"))
    found = {row["policy"]: (row["kind"], row["revisions"]) for row in content["evaluations"]}
    revisions = {"task": TASKS[ID].revision, "controller": 1}
    own, floor = ("controller", revisions), ("floor", revisions)
    assert found == {
        "mine.py:function": own,
        "mine.py:Constant": own,
        "zero_torque": floor,
        "hold": floor,
    }


TUNE = ("--env", ID, "--episodes", "2", "--budget", "80", "--output", "out")


@pytest.mark.parametrize(
    ("name", "settings"), [("function", {"stiffness", "damping"}), ("Constant", {"level"})]
)
def test_own_controllers_are_tuned_and_resumed_with_the_same_file(
    mine: Path, name: str, settings: set[str]
) -> None:
    result = run("tune", f"own/mine.py:{name}", *TUNE, "--set", f"{min(settings)}=0.3")
    assert result.exit_code == 0, result.output
    (folder,) = Path("out").iterdir()
    content = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    assert content["controller"] == content["code"]["name"] == f"mine.py:{name}"
    assert content["trials"] == 4
    assert settings <= set(content["settings"])
    journal = (folder / "study.log").read_text(encoding="utf-8")
    assert content["code"]["sha256"] in journal
    assert str(mine.parent) not in journal
    resumed = run("tune", f"own/mine.py:{name}", *TUNE, "--set", f"{min(settings)}=0.3", "--resume")
    assert resumed.exit_code == 0, resumed.output
    assert "4 trials with 80 steps were finished" in resumed.stderr
    other = run("tune", f"own/mine.py:{name}", *TUNE, "--set", f"{min(settings)}=0.4", "--resume").exception
    assert isinstance(other, InvalidValueError)


def test_file_that_changed_does_not_go_on_with_a_search(mine: Path) -> None:
    assert run("tune", "own/mine.py:Constant", *TUNE).exit_code == 0
    (folder,) = Path("out").iterdir()
    mine.write_text(SOURCE + "\n")
    folder.rename(Path("out") / f"{ID}_{folder_name(mine)}")
    error = run("tune", "own/mine.py:Constant", *TUNE, "--resume").exception
    assert isinstance(error, InvalidValueError)
    assert "to resume one of" in str(error)


def folder_name(path: Path) -> str:
    return f"mine.py-Constant_{hashlib.sha256(path.read_bytes()).hexdigest()[:16]}"


def test_fault_of_a_tuned_controller_is_reported(mine: Path) -> None:
    error = run("tune", "own/mine.py:NotFinite", *TUNE).exception
    assert isinstance(error, UserCodeError)
    assert (error.file, error.line) == (str(mine), line_of("class NotFinite"))
