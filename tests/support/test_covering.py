"""The combinations that stand for all leave out no kind, environment, controller or mode."""

from collections.abc import Callable, Hashable

import pytest

import prp_gym
from prp_gym.action_modes import list_action_modes
from prp_gym.baselines import BASELINES
from prp_gym.envs.action_mode import TORQUE
from tests.support import controller_episodes, mode_episodes
from tests.support.covering import by_turns, covering, one_of_each

ALL = [(row, column) for row in range(4) for column in "abc" if (row, column) != (0, "a")]


@pytest.mark.parametrize(
    "kind", [lambda each: each[1], lambda each: each[0] % 2, lambda each: each, lambda each: None]
)
def test_every_kind_and_every_member_is_covered(kind: Callable[[tuple[int, str]], Hashable]) -> None:
    chosen = covering(ALL, kind)
    assert {kind(each) for each in chosen} == {kind(each) for each in ALL}
    assert {row for row, _ in chosen} == set(range(4))
    assert {column for _, column in chosen} == set("abc")
    assert chosen == [each for each in ALL if each in chosen]
    assert len(one_of_each(ALL, kind)) == len({kind(each) for each in ALL})


def test_members_are_as_various_as_they_can_be() -> None:
    assert len(covering(ALL, lambda each: each[0])) == 4
    assert {column for _, column in one_of_each(ALL, lambda each: each[0])} == set("abc")


def test_by_turns_every_row_meets_every_column_and_every_column_every_choice() -> None:
    chosen = by_turns(range(4), "ab", ("x", "y", "z"))
    assert [each[:2] for each in chosen] == [(row, column) for row in range(4) for column in "ab"]
    assert {each[1:] for each in chosen} == {(column, choice) for column in "ab" for choice in "xyz"}


def test_every_controller_is_tested_on_every_kind_of_environment() -> None:
    for chosen in (controller_episodes.COVERING, controller_episodes.ONE_EACH):
        assert {name for name, _ in chosen} == set(prp_gym.list_envs())
        assert {controller for _, controller in chosen} == set(BASELINES)
    kinds = set(map(controller_episodes.kind_of, controller_episodes.COMBINATIONS))
    assert set(map(controller_episodes.kind_of, controller_episodes.COVERING)) == kinds
    assert len(BASELINES) < len(kinds) < len(controller_episodes.COMBINATIONS)


def test_every_mode_is_tested_on_the_arm_and_on_the_link_where_it_can_run() -> None:
    assert {name for name, _ in mode_episodes.COVERING} == set(prp_gym.list_envs())
    for chosen in (mode_episodes.COVERING, mode_episodes.COMBINATIONS):
        assert {mode for _, mode in chosen} == set(list_action_modes()) - {TORQUE}
    named = {mode for _, mode in mode_episodes.KINDS if not mode.startswith("residual")}
    assert named == {mode for mode in list_action_modes() if not mode.startswith("residual")} - {TORQUE}
