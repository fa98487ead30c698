"""Files of tuned controllers: written, read back strictly, and made into policies."""

import json
from collections.abc import Callable
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.artifacts import write_json
from prp_gym.baselines import CONTROLLERS, make_baseline
from prp_gym.errors import DataFileError, InvalidValueError, UnknownNameError
from prp_gym.tuning import TunedController, Validation, list_tuned_controllers, load_tuned_controller
from prp_gym.tuning import tuned_controller as module
from prp_gym.tuning.tune import EXTRA
from prp_gym.tuning.widening import NO_LIMIT

ENVIRONMENT = "PRP-Force-v0"
ENV = gymnasium.make(ENVIRONMENT, duration=0.02)
GAINS = {
    **vars(make_baseline("force_inner_position", ENV).settings),
    "bandwidth": 7.3,
    "inertia": [1 / 3] * 6,
}
VALIDATION = Validation(
    seed=500_000_000,
    episodes=100,
    score=0.58,
    score_of_start=0.51,
    kept_start=False,
    gain=0.07,
    gain_error=0.01,
    selection_seed=501_000_000,
    selection_episodes=20,
    selection=(0.6, 0.59),
    finalists=(0.58, 0.57),
)
CONTROLLER = TunedController(
    environment=ENVIRONMENT,
    controller="force_inner_position",
    scenarios=("realistic", "randomized"),
    control_frequency=500.0,
    settings={name: value for name, value in GAINS.items() if name != "model"},
    budget_steps=1000,
    used_steps=990,
    simulated_seconds=1.98,
    trials=3,
    episodes=20,
    seconds=0.1,
    history=((330, 0.5), (990, 0.6)),
    history_by_scenario={"realistic": (0.4, 0.5), "randomized": (0.6, 0.7)},
    score=0.6,
    score_of_start=0.5,
    edges={"bandwidth, high": NO_LIMIT},
    validation=VALIDATION,
    seed=0,
    command="prp-gym tune",
    versions={"python": "3.11.7"},
)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    write_json(tmp_path / "result.json", asdict(CONTROLLER))
    return tmp_path / "result.json"


def test_file_reads_back_as_it_was_written(path: Path) -> None:
    read = load_tuned_controller(path)
    for entry in fields(TunedController):
        if entry.name != "settings":
            assert getattr(read, entry.name) == getattr(CONTROLLER, entry.name), entry.name
    assert set(read.settings) == set(CONTROLLER.settings)
    for name, value in CONTROLLER.settings.items():
        np.testing.assert_array_equal(read.settings[name], value, err_msg=name)
    assert load_tuned_controller(str(path)).score == 0.6


def test_controller_is_made_with_the_settings_of_the_file(path: Path) -> None:
    policy = load_tuned_controller(path).make(ENV)
    assert type(policy) is CONTROLLERS.find("force_inner_position").policy
    assert policy.settings.bandwidth == 7.3
    np.testing.assert_array_equal(policy.settings.inertia, np.full(6, 1 / 3))
    assert policy.settings.stiffness == "estimated"


@pytest.mark.parametrize(
    ("environment_id", "rate", "what"),
    [
        ("PRP-ForcePosition-v0", 500, "environment of a tuned controller"),
        (ENVIRONMENT, 100, "control_frequency"),
    ],
)
def test_controller_is_made_for_its_environment_and_control_frequency_alone(
    path: Path, environment_id: str, rate: int, what: str
) -> None:
    env = gymnasium.make(environment_id, control_frequency=rate)
    with pytest.raises(InvalidValueError, match=f"^{what} is "):
        load_tuned_controller(path).make(env)
    env.close()


def change(name: str, value: Any) -> Callable[[dict[str, Any]], None]:
    return lambda content: content.update({name: value})


REFUSED = {
    "missing field": lambda content: content.pop("seed"),
    "field too many": change("more", 1),
    "text for a number": change("score", "0.6"),
    "null for a number": change("score", None),
    "boolean for a number": change("trials", True),
    "fraction for a count": change("trials", 1.5),
    "unknown environment": change("environment", "PRP-Nowhere-v0"),
    "unknown controller": change("controller", "joint_pid"),
    "unknown scenario": change("scenarios", ["within_limits"]),
    "unknown setting": lambda content: content["settings"].update(gain=1.0),
    "missing setting": lambda content: content["settings"].pop("inertia"),
    "negative setting": lambda content: content["settings"].update(inertia=[-1.0] * 6),
    "settings of another kind": change("settings", [1.0]),
    "history without scores": change("history", [[330], [990]]),
    "no history": change("history", []),
    "history of another scenario": change("history_by_scenario", {"report": [0.5, 0.6]}),
    "history of another length": change("history_by_scenario", {"realistic": [0.5], "randomized": [0.6]}),
    "history of text": change("history", [["330", 0.5]]),
    "history as an object": change("history", {"330": 0.5}),
    "validation without seed": lambda content: content["validation"].pop("seed"),
    "no validation": change("validation", []),
    "versions as a list": change("versions", []),
    "code as text": change("code", "mine.py"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_file_that_is_not_one_of_a_tuned_controller_is_refused_with_its_name(path: Path, case: str) -> None:
    content = json.loads(path.read_text(encoding="utf-8"))
    REFUSED[case](content)
    path.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(DataFileError, match=r"^file '.*result\.json': "):
        load_tuned_controller(path)


@pytest.mark.parametrize("text", ["", "{", "[1]", "3", '{"score": NaN}', "\x00\xff"])
def test_file_that_is_no_json_object_is_refused(path: Path, text: str) -> None:
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(DataFileError, match=r"^file '.*result\.json': "):
        load_tuned_controller(path)


def test_controller_of_a_users_own_reads_back_and_is_left_to_its_code(tmp_path: Path) -> None:
    own = {"name": "mine.py:PD", "sha256": "0" * 64}
    content = {**asdict(CONTROLLER), "controller": "mine.py:PD", "settings": {"gain": 2.0}, "code": own}
    write_json(tmp_path / "result.json", content)
    read = load_tuned_controller(tmp_path / "result.json")
    assert (read.controller, read.settings, read.code) == ("mine.py:PD", {"gain": 2.0}, own)
    with pytest.raises(InvalidValueError, match=r"'mine\.py:PD'; allowed: a registered controller"):
        read.make(ENV)


def test_name_that_is_neither_shipped_nor_a_file_is_refused(tmp_path: Path) -> None:
    for name in (str(tmp_path / "nothing.json"), str(tmp_path), "PRP-Force-v0/joint_pid"):
        with pytest.raises(UnknownNameError, match="unknown tuned controller "):
            load_tuned_controller(name)


def test_shipped_controllers_are_listed_by_environment_and_load_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "searches"
    write_json(folder / f"{ENVIRONMENT}_force_inner_position.json", asdict(CONTROLLER))
    write_json(folder / "other.json", asdict(CONTROLLER))
    module._shipped.cache_clear()
    monkeypatch.setattr(module, "files", lambda package: tmp_path)
    try:
        assert (
            list_tuned_controllers()
            == list_tuned_controllers(ENVIRONMENT)
            == [f"{ENVIRONMENT}/force_inner_position"]
        )
        assert list_tuned_controllers("PRP-ForcePosition-v0") == []
        assert load_tuned_controller(f"{ENVIRONMENT}/force_inner_position").score == 0.6
        with pytest.raises(UnknownNameError, match="unknown environment 'PRP-Force'"):
            list_tuned_controllers("PRP-Force")
    finally:
        module._shipped.cache_clear()


def test_every_shipped_controller_is_what_its_name_says() -> None:
    for name in list_tuned_controllers():
        controller = load_tuned_controller(name)
        assert f"{controller.environment}/{controller.controller}" == name
        env = gymnasium.make(controller.environment, control_frequency=controller.control_frequency)
        assert type(controller.make(env)) is CONTROLLERS.find(controller.controller).policy
        env.close()
        checked = controller.validation
        best = max(checked.finalists)
        assert checked.gain == pytest.approx(best - checked.score_of_start, abs=1e-12), name
        assert checked.kept_start == (checked.gain <= 2.0 * checked.gain_error), name
        assert checked.score == (checked.score_of_start if checked.kept_start else best), name
        assert controller.used_steps <= controller.budget_steps * (1.0 + EXTRA), name
