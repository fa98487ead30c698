"""Scenarios: what their data say, and that draws stay within them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from prp_gym.envs.base.scenarios import load_scenario
from prp_gym.errors import UnknownNameError
from prp_gym.robot.arrays import Array
from prp_gym.tasks import SCENARIOS, Range, Scenario
from prp_gym.tasks.ranges import Draws

SEEDS = st.integers(0, 2**32 - 1)
LOADED = {name: load_scenario(name) for name in SCENARIOS}
NONE = (0.0, 0.0, 0.0)
UNIT = (1.0, 1.0, 1.0)


def draw(box: Range, rng: np.random.Generator) -> Array:
    """One vector from one range."""
    vectors: Array = Draws({"vector": box}).draw([rng])["vector"]
    return np.array(vectors[0])


@pytest.fixture(params=SCENARIOS)
def scenario(request: pytest.FixtureRequest) -> Scenario:
    return LOADED[str(request.param)]


def test_range_flattens_nested_lists() -> None:
    table = {"low": [[0, 1], [2, 3]], "high": [[4, 5], [6, 7]]}
    assert Range.from_table(table) == Range((0.0, 1.0, 2.0, 3.0), (4.0, 5.0, 6.0, 7.0))


@given(SEEDS)
def test_draws_lie_in_their_range(seed: int) -> None:
    box = Range((-1.0, 0.0, 5.0), (1.0, 0.5, 5.0))
    drawn = draw(box, np.random.default_rng(seed))
    assert drawn.shape == (3,)
    assert (drawn >= box.low).all()
    assert (drawn <= box.high).all()
    assert drawn[2] == 5.0


def test_draws_cover_their_range() -> None:
    rng = np.random.default_rng(0)
    drawn = np.array([draw(Range((-1.0,), (3.0,)), rng) for _ in range(4000)])
    # the mean of 4000 uniform numbers on [-1, 3] has standard deviation 4/sqrt(12*4000) = 0.018: 5 of them
    assert drawn.mean() == pytest.approx(1.0, abs=0.09)
    # the chance that the extreme of 4000 misses the end by 0.02 is 0.995^4000 = 2e-9
    assert drawn.min() < -0.98
    assert drawn.max() > 2.98


def test_range_is_logarithmic_where_its_table_says_so() -> None:
    table = {"low": [50.0], "high": [5000.0], "logarithmic": True}
    assert Range.from_table(table) == Range((50.0,), (5000.0,), logarithmic=True)
    assert Range.from_table(table) != Range((50.0,), (5000.0,))


@given(SEEDS)
def test_logarithmic_draws_lie_in_their_range_and_use_the_same_random_numbers(seed: int) -> None:
    low, high = (50.0, 1e-3, 7.0), (5000.0, 1e3, 7.0)
    drawn = draw(Range(low, high, logarithmic=True), np.random.default_rng(seed))
    shares = draw(Range((0.0,) * 3, (1.0,) * 3), np.random.default_rng(seed))
    # an exponential of a logarithm, of at most 9: some roundings
    np.testing.assert_allclose(drawn, np.array(low) * (np.array(high) / low) ** shares, rtol=1e-14)
    assert (drawn >= np.array(low) * (1 - 1e-14)).all()
    assert (drawn <= np.array(high) * (1 + 1e-14)).all()


def test_logarithmic_draws_are_uniform_over_the_decades() -> None:
    rng = np.random.default_rng(0)
    drawn = np.array([draw(Range((50.0,), (5000.0,), logarithmic=True), rng)[0] for _ in range(4000)])
    # a quarter of the draws in each half decade: five standard deviations of 4000 such tosses
    counts = np.histogram(np.log10(drawn / 50.0), bins=[0.0, 0.5, 1.0, 1.5, 2.0])[0]
    np.testing.assert_allclose(counts / 4000, 0.25, rtol=0, atol=5 * np.sqrt(0.25 * 0.75 / 4000))


def test_scenarios_are_known_by_their_names(scenario: Scenario) -> None:
    assert LOADED[scenario.name] is scenario
    assert scenario.description.endswith(".")


def test_report_is_the_reports_ideal_experiment() -> None:
    report = LOADED["report"]
    assert report.deterministic
    assert report.ideal_plant
    assert not report.joint_stops
    assert report.torque_limit_factor == 100.0
    assert report.torque_noise == report.force_noise == report.force_bias == 0.0
    assert report.delay_steps == 0


def test_randomized_has_stops_and_nominal_limits_and_the_nominal_plant() -> None:
    randomized = LOADED["randomized"]
    assert not randomized.deterministic
    assert randomized.ideal_plant
    assert randomized.joint_stops
    assert randomized.torque_limit_factor == 1.0
    assert randomized.torque_noise == randomized.force_noise == randomized.force_bias == 0.0
    assert randomized.delay_steps == 0


def test_realistic_departs_from_the_nominal_arm_as_the_design_document_says() -> None:
    realistic = LOADED["realistic"]
    assert not realistic.deterministic
    assert not realistic.ideal_plant
    assert realistic.joint_stops
    assert realistic.torque_limit_factor == 1.0
    assert realistic.mass_factor == Range((0.7,) * 3, (1.3,) * 3)
    assert min(realistic.viscous_friction.high) > 0.0
    assert min(realistic.coulomb_friction.high) > 0.0
    assert min(realistic.torque_noise, realistic.force_noise, realistic.force_bias) > 0.0
    assert realistic.delay_steps == 1


@given(SEEDS)
def test_drawn_plants_lie_in_the_declared_ranges(seed: int) -> None:
    for scenario in LOADED.values():
        plant = scenario.draw_plants([np.random.default_rng(seed)])
        for values, box in (
            (plant.mass_factor, scenario.mass_factor),
            (plant.viscous_friction, scenario.viscous_friction),
            (plant.coulomb_friction, scenario.coulomb_friction),
        ):
            assert values.shape == (1, 3)
            assert (values >= box.low).all()
            assert (values <= box.high).all()


def test_plants_of_the_realistic_scenario_differ_between_seeds() -> None:
    one, other = (LOADED["realistic"].draw_plants([np.random.default_rng(seed)]) for seed in (0, 1))
    assert (one.mass_factor != other.mass_factor).all()
    assert (one.viscous_friction != other.viscous_friction).all()
    assert (one.coulomb_friction != other.coulomb_friction).all()


def test_every_scenario_takes_as_many_random_numbers_for_its_plant() -> None:
    following = set()
    for scenario in LOADED.values():
        rng = np.random.default_rng(3)
        scenario.draw_plants([rng])
        following.add(rng.random())
    assert len(following) == 1


IDEAL = LOADED["randomized"]


@pytest.mark.parametrize(
    "changed",
    [
        replace(IDEAL, mass_factor=Range(UNIT, (1.0, 1.1, 1.0))),
        replace(IDEAL, mass_factor=Range((2.0, 2.0, 2.0), (2.0, 2.0, 2.0))),
        replace(IDEAL, viscous_friction=Range(NONE, (0.0, 0.0, 0.1))),
        replace(IDEAL, coulomb_friction=Range(NONE, (0.1, 0.0, 0.0))),
    ],
)
def test_any_departure_of_masses_or_friction_makes_the_plant_not_ideal(changed: Scenario) -> None:
    assert IDEAL.ideal_plant
    assert not changed.ideal_plant


def test_unknown_scenario_is_named_with_the_known_ones() -> None:
    with pytest.raises(UnknownNameError, match="unknown scenario 'realstic'") as caught:
        load_scenario("realstic")
    assert caught.value.valid == tuple(sorted(SCENARIOS))
    assert "Did you mean 'realistic'?" in str(caught.value)
