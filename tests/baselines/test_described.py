"""What controllers show of themselves: name, gains, environment, settings, one episode."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest

from prp_gym import make_baseline
from prp_gym.baselines.base.control_interface import ControlInterface
from prp_gym.baselines.joint_pd import JointPDController


@pytest.fixture(scope="module")
def env() -> Iterator[gymnasium.Env[Any, Any]]:
    with gymnasium.make("PRP-JointTracking-v0", duration=0.1) as made:
        yield made


def test_text_says_name_gains_and_environment(env: gymnasium.Env[Any, Any]) -> None:
    assert repr(make_baseline("joint_pd", env)) == (
        "<joint_pd with gains 'tuned', for PRP-JointTracking-v0 at 500 Hz>"
    )
    report = make_baseline("joint_pd", env, "report", proportional_gain=[1.0, 2.0, 3.0])
    assert str(report).startswith("<joint_pd with gains 'report', proportional_gain changed, for ")


def test_text_of_a_controller_made_without_a_name_has_its_class(env: gymnasium.Env[Any, Any]) -> None:
    settings = make_baseline("joint_pd", env).settings
    made = JointPDController(ControlInterface.of(env), settings)
    assert repr(made).startswith("<JointPDController with given settings, for PRP-JointTracking-v0")


def test_table_has_every_setting_with_its_unit(env: gymnasium.Env[Any, Any]) -> None:
    controller = make_baseline("joint_pd", env)
    rows = {row["setting"]: row for row in controller.table.records}
    settings = controller.settings
    assert set(rows) == {*settings.vectors, *settings.numbers, *settings.choices}
    assert rows["proportional_gain"]["value"] == settings.proportional_gain.tolist()
    assert rows["proportional_gain"]["unit"] == settings.vectors["proportional_gain"].unit
    root = ElementTree.fromstring(controller._repr_html_())
    assert root.findtext("caption") == "joint_pd with gains 'tuned', for PRP-JointTracking-v0"


def test_data_frame_has_a_row_for_each_component(env: gymnasium.Env[Any, Any]) -> None:
    pytest.importorskip("pandas")
    controller = make_baseline("joint_pd", env)
    frame = controller.to_frame()
    own = frame[frame["setting"] == "proportional_gain"]
    assert own["component"].tolist() == [1, 2, 3]
    np.testing.assert_array_equal(own["value"], controller.settings.proportional_gain)


def test_figure_is_one_episode_of_the_controller(env: gymnasium.Env[Any, Any]) -> None:
    title = make_baseline("joint_pd", env).plot(env, seed=5).get_suptitle()
    assert "seed 5, joint_pd with gains 'tuned': mean reward" in title
