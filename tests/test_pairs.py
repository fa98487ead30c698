"""Pairs: which there are, and what playing one gives."""

import json
import pickle
from dataclasses import replace

import gymnasium
import pytest

from prp_gym import list_envs
from prp_gym.baselines import BASELINES, list_baselines, make_baseline
from prp_gym.errors import InvalidValueError, MissingFieldError, UnknownNameError
from prp_gym.evaluation import evaluate
from prp_gym.pairs import Pair, list_pairs, play_pair

REPORT = ("PRP-JointTracking-v0", "report")
RANDOMIZED = ("PRP-JointTracking-v0", "randomized")
PAIR = Pair(*RANDOMIZED, "joint_pd", "tuned_50hz", 50.0, 2, 7)


def test_pair_is_played_as_the_evaluator_plays_it() -> None:
    env = gymnasium.make(PAIR.environment_id, scenario="randomized", control_frequency=50.0)
    expected = evaluate(make_baseline("joint_pd", env, "tuned_50hz"), env, episodes=2, seed=7)
    env.close()
    record = play_pair(PAIR)
    assert record["score"] == expected.score._asdict()
    assert record["seeds"] == [7, 8]
    assert record["episodes"]["energy"] == expected.metrics["energy"].tolist()
    assert (record["settings"]["gains"], record["control_period"]) == ("tuned_50hz", 0.02)


def test_record_is_strict_json_to_the_last_bit() -> None:
    record = play_pair(PAIR)
    assert json.loads(json.dumps(record, allow_nan=False)) == record


def test_pair_and_its_record_survive_the_way_between_processes() -> None:
    assert pickle.loads(pickle.dumps(PAIR)) == PAIR
    record = play_pair(PAIR)
    assert pickle.loads(pickle.dumps(record)) == record


def test_pairs_are_the_laws_that_can_run_in_the_order_of_the_places() -> None:
    places = [(environment_id, "randomized") for environment_id in reversed(list_envs())]
    pairs = list_pairs(places, list(BASELINES), "tuned", 500.0, 3, 4)
    expected = []
    for environment_id, scenario in places:
        env = gymnasium.make(environment_id)
        laws = list_baselines(env.get_wrapper_attr("observation_layout"))
        env.close()
        expected += [Pair(environment_id, scenario, law, "tuned", 500.0, 3, 4) for law in laws]
    assert pairs == expected
    assert len({pair.name for pair in pairs}) == len(pairs)


def test_deterministic_scenario_is_played_once() -> None:
    pairs = list_pairs([REPORT, RANDOMIZED], ["joint_pd"], "tuned", 500.0, 5, 0)
    assert [pair.episodes for pair in pairs] == [1, 5]


def test_gains_that_cannot_be_used_are_refused_before_anything_is_played() -> None:
    with pytest.raises(InvalidValueError, match="control_frequency is 50"):
        list_pairs([REPORT], ["joint_pd"], "tuned", 50.0, 1, 0)
    with pytest.raises(UnknownNameError, match="unknown gain set of law 'joint_pd'"):
        list_pairs([REPORT], ["joint_pd"], "nothing", 500.0, 1, 0)


def test_law_that_lacks_what_it_reads_is_refused_where_it_is_played() -> None:
    with pytest.raises(MissingFieldError, match="law 'impedance'"):
        play_pair(replace(PAIR, law="impedance"))
