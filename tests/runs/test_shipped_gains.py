"""Results of searches become gain sets that give the settings that were validated."""

import shutil
from contextlib import closing
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.artifacts import write_json
from prp_gym.baselines import CONTROLLERS, ControllerData, ControllerSpec, make_baseline
from prp_gym.baselines.base import spec as declarations
from prp_gym.errors import InvalidValueError
from prp_gym.files.checksum import seal
from prp_gym.files.toml_text import parse_toml
from prp_gym.runs.shipped_gains import Shipped, ship_result
from prp_gym.tuning import SearchSpace, TunedController, load_tuned_controller
from prp_gym.tuning.candidates import Candidates
from prp_gym.tuning.validation import rounded_settings
from tests.tuning.test_tuned_controller import CONTROLLER as RESULT

FACTORS = np.array([1.3, 0.7, 1.0, 2.0])


def moved(spec: ControllerSpec, env: Any) -> dict[str, Any]:
    """Settings somewhere in the search space of a controller, as validated."""
    start: Any = make_baseline(spec, env)
    space = SearchSpace.of(spec, start.settings)
    factors = {item.name: float(FACTORS[number % 4]) for number, item in enumerate(space.parameters)}
    return rounded_settings(Candidates(space, lambda values: make_baseline(spec, env, **values)), factors)


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A function that gives a controller a copy of its data file, in which gains may be written."""

    def copied(name: str) -> ControllerSpec:
        spec = CONTROLLERS.find(name)
        file = tmp_path / f"{name}.toml"
        shutil.copy(str(spec.data.file), file)
        made = replace(spec, data=ControllerData(file, spec.data.target_impedance_sets))
        monkeypatch.setattr(CONTROLLERS, "find", {name: made}.__getitem__)
        return made

    yield copied
    declarations._tables.cache_clear()


def result_of(spec: ControllerSpec, env: Any, folder: Path, kept: bool = False) -> Path:
    settings = moved(spec, env)
    validation = replace(RESULT.validation, kept_start=kept)
    result = replace(
        RESULT,
        environment=env.unwrapped.task.environment_id,
        controller=spec.name,
        settings=settings,
        validation=validation,
    )
    path = folder / "result.json"
    write_json(path, seal(asdict(result)))
    return path


def shipped(spec: ControllerSpec, env: Any, folder: Path, kept: bool = False) -> Shipped:
    found = ship_result(result_of(spec, env, folder, kept), env, folder / "searches")
    declarations._tables.cache_clear()
    return found


@pytest.mark.parametrize(
    ("controller", "environment_id"),
    [(spec.name, name) for spec in CONTROLLERS.values() for name in spec.data.intended[:1]],
)
def test_tuned_gains_are_then_the_validated_settings(
    own: Any, tmp_path: Path, controller: str, environment_id: str
) -> None:
    spec = own(controller)
    before = parse_toml(spec.data.file.read_text(encoding="utf-8"))
    with closing(gymnasium.make(environment_id)) as env:
        found = shipped(spec, env, tmp_path)
        made: Any = make_baseline(spec, env).settings
        for name, value in found.tuned.settings.items():
            # a target impedance is a factor of six digits times what the task asks for
            tolerance = 1e-6 if name in spec.policy.rendered else 0.0
            if isinstance(value, str):
                assert getattr(made, name) == value
            else:
                np.testing.assert_allclose(getattr(made, name), value, rtol=tolerance, err_msg=name)
    after = parse_toml(spec.data.file.read_text(encoding="utf-8"))
    own_table = after["gains"]["tuned"].pop(environment_id)
    before["gains"]["tuned"].pop(environment_id, None)
    assert after == before  # other sets, environments and the search space
    for part in (controller, "--budget 1000", "0.5800", "0.5100", "seed 500000000"):
        assert part in own_table["source"]
    assert (
        max(own_table.get("minimum_frequency", 0.0), before["gains"]["tuned"]["minimum_frequency"]) == 500.0
    )


def test_tuned_gains_follow_the_target_impedance_that_is_asked_for(own: Any, tmp_path: Path) -> None:
    spec = own("impedance")
    with closing(gymnasium.make("PRP-Impedance-v0")) as env:
        found = shipped(spec, env, tmp_path)
    ratio = np.asarray(found.tuned.settings["stiffness"]) / 50.0
    with closing(gymnasium.make("PRP-Impedance-v0", target_stiffness=80.0)) as env:
        made: Any = make_baseline(spec, env).settings
    np.testing.assert_allclose(made.stiffness, 80.0 * ratio, rtol=1e-6)  # six digits


def test_record_is_that_of_the_search(own: Any, tmp_path: Path) -> None:
    spec = own("joint_pd")
    with closing(gymnasium.make("PRP-JointTracking-v0")) as env:
        found = shipped(spec, env, tmp_path)
    assert found.record == tmp_path / "searches" / "PRP-JointTracking-v0_joint_pd.json"
    read = load_tuned_controller(found.record)
    assert isinstance(read, TunedController)
    assert read.settings == load_tuned_controller(tmp_path / "result.json").settings


def test_gains_stay_as_they_are_where_the_start_was_kept(own: Any, tmp_path: Path) -> None:
    spec = own("joint_pd")
    text = spec.data.file.read_bytes()
    with closing(gymnasium.make("PRP-JointTracking-v0")) as env:
        found = shipped(spec, env, tmp_path, kept=True)
    assert found.gains is None
    assert spec.data.file.read_bytes() == text
    assert found.record.exists()


def test_controller_without_a_data_file_is_refused(
    own: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    spec = own("joint_pd")
    with closing(gymnasium.make("PRP-JointTracking-v0")) as env:
        path = result_of(spec, env, tmp_path)
        bare = replace(spec, data=ControllerData())
        monkeypatch.setattr(CONTROLLERS, "find", {"joint_pd": bare}.__getitem__)
        with pytest.raises(InvalidValueError, match="one with a data file of gains"):
            ship_result(path, env, tmp_path)
