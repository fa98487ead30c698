"""Gains of one's own: mappings and TOML files; declarations of one's own beside the suite's."""

import pickle
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym.baselines import (
    BASELINES,
    ControllerData,
    ControllerSpec,
    JointPDController,
    gain_sets,
    list_baselines,
    load_gains,
    make_baseline,
    make_controller,
    register_controller,
)
from prp_gym.errors import GainsFileError, InvalidValueError, MissingFieldError, PRPError, UnknownNameError
from prp_gym.registry import NOT_IN_THE_REPORT
from tests.support.control_interface import INTERFACE, LINK_INTERFACE

ENVIRONMENT = "PRP-JointTracking-v0"
FILE = """
proportional_gain = [60.0, 600.0, 6.0]
derivative_gain = 9.0
source = "a search of my own"

["PRP-JointTracking-v0"]
derivative_gain = 12.0
"""


@pytest.fixture
def env() -> Iterator[Any]:
    with closing(gymnasium.make(ENVIRONMENT)) as made:
        yield made


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "my.toml"
    path.write_text(FILE, encoding="utf-8")
    return path


def gains_of(policy: Any) -> list[list[float]]:
    return [policy.settings.proportional_gain.tolist(), policy.settings.derivative_gain.tolist()]


def test_mapping_is_a_gain_set(env: Any) -> None:
    made = make_baseline("joint_pd", env, {"proportional_gain": 7.0, "derivative_gain": [1, 2, 3]})
    assert gains_of(made) == [[7.0] * 3, [1.0, 2.0, 3.0]]
    own = {"derivative_gain": 5.0, "source": "mine"}
    common = {"proportional_gain": 7.0, "derivative_gain": 1.0, ENVIRONMENT: own, "PRP-Force-v0": {}}
    assert gains_of(make_baseline("joint_pd", env, common)) == [[7.0] * 3, [5.0] * 3]
    assert gains_of(make_baseline("joint_pd", env, common, derivative_gain=6.0))[1] == [6.0] * 3


@pytest.mark.parametrize("kind", [str, Path])
def test_file_is_a_gain_set_with_what_differs_on_an_environment(env: Any, file: Path, kind: Any) -> None:
    made = make_baseline("joint_pd", env, kind(file))
    assert gains_of(made) == [[60.0, 600.0, 6.0], [12.0] * 3]
    with closing(gymnasium.make("PRP-JointRegulation-v0")) as other:
        assert gains_of(make_baseline("joint_pd", other, kind(file)))[1] == [9.0] * 3
    assert gains_of(make_baseline("joint_pd", env, file, derivative_gain=4.0))[1] == [4.0] * 3


def test_file_may_say_from_which_frequency_it_serves(env: Any, file: Path) -> None:
    file.write_text("minimum_frequency = 1000\n" + FILE, encoding="utf-8")
    allowed = r"at least 1000 with gains of '.*my\.toml' of controller 'joint_pd'"
    with pytest.raises(InvalidValueError, match=rf"control_frequency is 500\.0 Hz; allowed: {allowed}"):
        make_baseline("joint_pd", env, file)
    with closing(gymnasium.make(ENVIRONMENT, control_frequency=1000)) as fast:
        assert gains_of(make_baseline("joint_pd", fast, file))[1] == [12.0] * 3


def test_task_s_target_impedance_replaces_no_gains_of_one_s_own() -> None:
    with closing(gymnasium.make("PRP-Impedance-v0", target_stiffness=[99.0] * 6)) as env:
        gains = {"inertia": 1.0, "damping": 10.0, "stiffness": 40.0}
        assert make_baseline("impedance", env, gains).settings.stiffness.tolist() == [40.0] * 6
        factors = load_gains("impedance", "tuned", "PRP-Impedance-v0").get("target_factor", {})
        expected = (99.0 * np.array(factors.get("stiffness", [1.0] * 6))).tolist()
        assert make_baseline("impedance", env, "tuned").settings.stiffness.tolist() == expected


@pytest.mark.parametrize(
    ("text", "what"),
    [
        (None, "No such file or directory"),
        ("proportional_gain = ", "cannot be read as TOML"),
        (
            "proportional_gian = 1.0",
            "unknown setting of controller 'joint_pd' 'proportional_gian'. Did you mean",
        ),
        ('["PRP-Fource-v0"]\nderivative_gain = 1.0', "unknown environment 'PRP-Fource-v0'. Did you mean"),
        ('["PRP-Force-v0"]\ngain = 1.0', "unknown setting of controller 'joint_pd' 'gain'"),
        (
            "proportional_gain = 1.0",
            "settings of controller 'joint_pd' is 'proportional_gain'; allowed: also",
        ),
        ("proportional_gain = -1.0\nderivative_gain = 1.0", "proportional_gain is -1.0"),
        ('proportional_gain = "high"\nderivative_gain = 1.0', "proportional_gain is 'high'"),
        ("minimum_frequency = true", "minimum_frequency is True Hz"),
        ("minimum_frequency = nan", "minimum_frequency is nan Hz"),
    ],
)
def test_file_that_cannot_be_used_is_named_with_the_reason(
    env: Any, tmp_path: Path, text: str | None, what: str
) -> None:
    path = tmp_path / "my.toml"
    if text is not None:
        path.write_text(text, encoding="utf-8")
    with pytest.raises(GainsFileError) as caught:
        make_baseline("joint_pd", env, path)
    assert str(caught.value).startswith(f"gains file {str(path)!r}: ")
    assert what in str(caught.value)
    assert (caught.value.path, caught.value.what in str(caught.value)) == (str(path), True)
    again = pickle.loads(pickle.dumps(caught.value))
    assert (str(again), again.path, again.what) == (str(caught.value), caught.value.path, caught.value.what)


def test_folder_and_bytes_that_are_no_text_are_no_file_of_gains(env: Any, tmp_path: Path) -> None:
    (tmp_path / "latin.toml").write_bytes(b"source = '\xe9'")
    with pytest.raises(GainsFileError, match="is not text in UTF-8"):
        make_baseline("joint_pd", env, tmp_path / "latin.toml")
    with pytest.raises(GainsFileError, match="is a directory"):
        make_baseline("joint_pd", env, tmp_path)


def test_override_that_is_refused_is_not_blamed_on_the_file(env: Any, file: Path) -> None:
    with pytest.raises(InvalidValueError, match=r"^derivative_gain is -1\.0"):
        make_baseline("joint_pd", env, file, derivative_gain=-1.0)


@pytest.mark.parametrize(
    ("gains", "error", "match"),
    [
        ({"proportional_gain": 1.0}, InvalidValueError, "also derivative_gain"),
        ({"gain": 1.0}, UnknownNameError, "unknown setting of controller 'joint_pd' 'gain'"),
        ({"PRP-X-v0": {}}, UnknownNameError, "unknown environment 'PRP-X-v0'"),
        ({ENVIRONMENT: {"gain": 1.0}}, UnknownNameError, "unknown setting .* 'gain'"),
        (3.0, InvalidValueError, "gains of controller 'joint_pd' is 3.0; allowed: a gain set's name"),
        (None, InvalidValueError, "gains of controller 'joint_pd' is None"),
        ("my_gains", UnknownNameError, "gain set of controller 'joint_pd' 'my_gains'"),
    ],
)
def test_gains_that_mean_nothing_are_refused(env: Any, gains: Any, error: type[PRPError], match: str) -> None:
    with pytest.raises(error, match=match):
        make_baseline("joint_pd", env, gains)


MINE = ControllerSpec("mine", "a PD controller of one's own", JointPDController)


def test_declaration_is_made_without_registration(env: Any) -> None:
    made = make_baseline(MINE, env, {"proportional_gain": 1.0, "derivative_gain": 2.0})
    assert type(made) is JointPDController
    assert gains_of(made) == [[1.0] * 3, [2.0] * 3]
    direct = make_controller(MINE, INTERFACE, {"proportional_gain": 1.0, "derivative_gain": 2.0})
    assert gains_of(direct) == gains_of(made)


def test_set_tuned_stands_for_the_defaults_where_there_is_none(env: Any) -> None:
    assert gain_sets(MINE) == ("tuned",)
    with pytest.raises(InvalidValueError, match="of controller 'mine' is 'none'; allowed: also prop"):
        make_baseline(MINE, env)
    assert gains_of(make_baseline(MINE, env, proportional_gain=3.0, derivative_gain=4.0))[0] == [3.0] * 3


def test_registered_declaration_is_found_by_name_after_the_suite_s_own(env: Any) -> None:
    before = list_baselines()
    assert register_controller(MINE) is MINE
    try:
        assert list_baselines() == [*before, "mine"]
        made = make_baseline("mine", env, proportional_gain=3.0, derivative_gain=4.0)
        assert type(made) is JointPDController
        with pytest.raises(InvalidValueError, match="name of baseline is 'mine'"):
            register_controller(replace(MINE, summary="another"))
    finally:
        BASELINES.unregister("mine")
    assert list_baselines() == before


@pytest.mark.parametrize("name", ["two words", "", "a/b"])
def test_name_that_cannot_be_a_file_s_is_refused(name: str) -> None:
    with pytest.raises(InvalidValueError, match="name of baseline"):
        register_controller(replace(MINE, name=name))


def test_missing_field_is_said_of_the_declared_name() -> None:
    spec = replace(BASELINES["impedance"], name="soft")
    with pytest.raises(MissingFieldError, match="controller 'soft' reads") as caught:
        make_controller(spec, LINK_INTERFACE, {"inertia": 1.0, "damping": 1.0, "stiffness": 1.0})
    assert "end_effector_pose" in caught.value.missing
    direct = {"proportional_gain": 1.0, "derivative_gain": 1.0, "contact": "compensated"}
    with pytest.raises(MissingFieldError, match=r"'operational_inverse_dynamics' reads .*contact_force"):
        make_controller("operational_inverse_dynamics", INTERFACE, direct)


@pytest.mark.parametrize(
    ("text", "what"),
    [
        (None, "No such file or directory"),
        ("[gains", "cannot be read as TOML"),
        ("[gain.tuned]\nstiffness = 1.0", "unknown table 'gain'; allowed: gains, search"),
        ("[gains]\nstiffness = 1.0", "'gains' must hold tables"),
        ("search = 1", "'search' must hold tables"),
    ],
)
def test_data_file_of_another_layout_is_refused_when_it_is_read(
    tmp_path: Path, text: str | None, what: str
) -> None:
    path = tmp_path / "mine.toml"
    if text is not None:
        path.write_text(text, encoding="utf-8")
    spec = replace(MINE, data=ControllerData.beside(str(tmp_path / "mine.py"), ("tuned",)))
    assert spec.data == ControllerData(path, ("tuned",))
    for read in (lambda: spec.data.gains, lambda: spec.data.search, lambda: gain_sets(spec)):
        with pytest.raises(GainsFileError, match=what):
            read()


OF_THE_REPORT = [spec for spec in BASELINES.values() if spec.chapter != NOT_IN_THE_REPORT]
OLD_NAMES = [spec.policy.__name__.removesuffix("Controller") for spec in OF_THE_REPORT]


@pytest.mark.parametrize("name", OLD_NAMES)
def test_old_names_of_the_classes_warn_and_are_the_new_ones(name: str) -> None:
    import prp_gym.baselines as package

    with pytest.warns(DeprecationWarning, match=f"{name} is now called {name}Controller"):
        assert getattr(package, name) is getattr(package, f"{name}Controller")
    assert len(OLD_NAMES) == 10


def test_other_names_do_not_exist() -> None:
    import prp_gym.baselines as package

    with pytest.raises(AttributeError, match="has no attribute 'SlidingMode'"):
        _ = package.SlidingMode


REVISIONS = {"force_inner_position": 2, "parallel_force_position": 2}
"""Revision of the controllers that gave other results before taring and approach by force."""


@pytest.mark.parametrize("controller", BASELINES)
def test_declaration_stands_beside_its_data_and_follows_the_report(controller: str) -> None:
    spec = BASELINES[controller]
    assert spec.data.file is not None
    assert spec.policy.__module__ == f"prp_gym.baselines.{controller}"
    assert spec.data.file.name == f"{controller}.toml"
    assert spec.data.search
    assert spec.revision == REVISIONS.get(controller, 1)


def test_controllers_of_the_report_come_first_in_its_order() -> None:
    assert list(BASELINES.values())[: len(OF_THE_REPORT)] == OF_THE_REPORT
    assert [int(spec.chapter) for spec in OF_THE_REPORT] == list(range(6, 16))
