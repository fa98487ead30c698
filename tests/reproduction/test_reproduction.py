"""The data of the report's experiments, complete and resolvable; verdicts, answers, recorded runs."""

from dataclasses import fields, replace
from importlib.resources import files
from typing import Any

import numpy as np
import pytest

from prp_gym.baselines import BASELINES
from prp_gym.baselines.base.gains import gain_sets
from prp_gym.errors import InvalidValueError, ShapeError, UnknownNameError
from prp_gym.reproduction import ExperimentRun, FigureOutcome, Verdict, judge, load_catalogue, record_run
from prp_gym.reproduction.catalogue import CHAPTERS
from prp_gym.reproduction.experiment import Number, Prediction
from prp_gym.reproduction.outcome import fill, placeholders, show, unit_of
from prp_gym.reproduction.predictions import FORMULAS
from prp_gym.reproduction.run import StateRecorder, check_names
from prp_gym.tasks.registration import list_envs

CATALOGUE = load_catalogue()
FIGURES = [5, 6, 7, 8, *range(11, 17), 19, 20, 23, 24, 27, 28, 30, 31, 32, 35, 36, 37, 40, 41, 42, 45, 46, 49]
QUESTIONS = ["6.1", "6.2", "6.3", "6.4", "7.1", "7.2", "7.3", "8", "9", "10", "11.2", "11.3", "11.4"]
QUESTIONS += ["12.2", "12.3", "12.4", "13.2", "13.3", "13.4", "14", "15"]
# of the report, whether this suite has them already or not
ENVIRONMENTS = {f"PRP-{name}-v0" for name in ("JointRegulation", "JointTracking", "Adaptive")}
ENVIRONMENTS |= {f"PRP-{name}-v0" for name in ("PoseRegulation", "PoseTracking", "Compliance", "Impedance")}
ENVIRONMENTS |= {f"PRP-{name}-v0" for name in ("Admittance", "Force", "ForcePosition")}
CONTROLLERS = {
    "joint_pd",
    "joint_inverse_dynamics",
    "adaptive",
    "operational_pd",
    "operational_inverse_dynamics",
}
CONTROLLERS |= {"compliance", "impedance", "admittance", "force_inner_position", "parallel_force_position"}
CHECKS = [check for experiment in CATALOGUE.experiments.values() for check in experiment.checks]


def test_every_figure_is_there_in_order() -> None:
    assert list(CATALOGUE.experiments) == FIGURES
    assert [item.number for item in CATALOGUE.choose([])] == FIGURES
    assert [item.number for item in CATALOGUE.choose([13, 5, 13])] == [5, 13]


def test_every_question_is_answered_by_numbers_that_were_checked() -> None:
    assert [answer.question for answer in CATALOGUE.answers] == QUESTIONS
    for answer in CATALOGUE.answers:
        named = placeholders(answer.text)
        assert {check.question for check in CHECKS if check.name in named} >= {answer.question}
        assert answer.text.endswith(".")
    assert {check.question for check in CHECKS} == set(QUESTIONS)


def test_every_figure_says_what_the_report_shows_and_how_that_was_checked() -> None:
    for experiment in CATALOGUE.experiments.values():
        assert experiment.reading.endswith(".")
        assert experiment.checks
        assert experiment.panels
        section = experiment.section.split(".")
        # sections 8, 9, 10, 14 and 15 have one question each
        assert {check.question for check in experiment.checks} <= {experiment.section, section[0]}
        assert sum(len(panel.components) for panel in experiment.panels) <= 4  # 700 pixels are no more


def test_every_run_is_of_the_report_and_is_used() -> None:
    used = {name for experiment in CATALOGUE.experiments.values() for name in experiment.runs}
    assert used == set(CATALOGUE.runs)
    assert {run.environment for run in CATALOGUE.runs.values()} == ENVIRONMENTS
    assert {run.controller for run in CATALOGUE.runs.values()} == CONTROLLERS


@pytest.mark.parametrize("run", CATALOGUE.runs.values(), ids=lambda run: run.name)
def test_names_of_a_run_resolve(run: ExperimentRun) -> None:
    if run.environment not in list_envs() or run.controller not in BASELINES or not gain_sets(run.controller):
        pytest.skip("this suite does not have the task or the controller yet")
    check_names(run)
    settings = {entry.name for entry in fields(BASELINES[run.controller].settings_class)}
    assert {"model" if name == "model_masses" else name for name in run.overrides} <= settings


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.name)
def test_prediction_of_a_check_can_be_computed(check: Any) -> None:
    predicted = check.predict.compute()
    assert predicted.ndim == 1
    assert np.isfinite(predicted).all()
    assert len(check.unit) in (1, len(predicted))
    tolerance = check.tolerance(predicted)
    assert tolerance.shape == predicted.shape
    assert (tolerance > 0.0).all()
    components = check.measure.arguments.get("components", [])
    assert len(components) * len(check.measure.arguments.get("times", [0.0])) in (0, len(predicted))
    assert check.predict.text
    assert check.reason


def test_every_formula_is_used() -> None:
    used = {check.predict.formula.name for check in CHECKS if isinstance(check.predict, Prediction)}
    assert used == set(FORMULAS)


def test_tolerances_tell_a_prediction_from_nothing_and_from_twice_itself() -> None:
    for check in CHECKS:
        predicted = check.predict.compute()
        largest = np.abs(predicted).max()
        if largest > 0.0:
            assert (check.tolerance(predicted) < 0.25 * largest).any(), check.name


def test_no_text_was_left_open() -> None:
    for chapter in CHAPTERS:
        text = files("prp_gym.reproduction").joinpath(chapter).read_text(encoding="utf-8")
        assert "TODO" not in text
        assert '""' not in text.replace('"""', "")


def test_unknown_figure_names_the_valid_ones() -> None:
    with pytest.raises(UnknownNameError) as caught:
        CATALOGUE.choose([5, 9])
    assert caught.value.valid == tuple(f"{number:02d}" for number in FIGURES)


def verdict_of(predicted: list[float], measured: list[float], **changes: Any) -> Verdict:
    check = replace(CATALOGUE.experiments[6].checks[0], **{"absolute": (0.1,), "relative": 0.0, **changes})
    numbers = np.array(predicted)
    bounds = check.tolerance(numbers), check.widest_tolerance(numbers)
    return Verdict(check, numbers, np.array(measured), *bounds)


FRICTION = {"explanation": "friction", "explained_tolerance": (0.5,)}


@pytest.mark.parametrize(
    ("measured", "changes", "word"),
    [
        ([1.0, 2.0], {}, "pass"),
        ([1.0999, 2.0999], {}, "pass"),
        ([0.8999, 2.0], {}, "FAIL"),
        ([1.0, 2.1001], {}, "FAIL"),
        ([1.0, np.nan], {}, "FAIL"),
        ([1.0, np.inf], {}, "FAIL"),
        ([1.0, 2.29], {"relative": 0.1}, "pass"),
        ([1.21, 2.0], {"relative": 0.1}, "FAIL"),
        ([1.05, 2.3], {"absolute": (0.06, 0.4)}, "pass"),
        ([1.3, 2.0], {"absolute": (0.06, 0.4)}, "FAIL"),
        ([1.0, 2.1001], FRICTION, "explained"),
        ([0.5001, 2.4999], FRICTION, "explained"),
        ([1.0, 2.5001], FRICTION, "FAIL"),
        ([1.0, np.nan], FRICTION, "FAIL"),
        ([-np.inf, 2.0], FRICTION, "FAIL"),
        ([1.0, 2.0], FRICTION, "pass"),
        ([1.0, 2.3], {**FRICTION, "explained_tolerance": (0.1, 0.4)}, "explained"),
        ([1.3, 2.0], {**FRICTION, "explained_tolerance": (0.1, 0.4)}, "FAIL"),
    ],
)
def test_verdict_compares_number_by_number(measured: list[float], changes: dict[str, Any], word: str) -> None:
    assert verdict_of([1.0, 2.0], measured, **changes).word == word


@pytest.mark.parametrize(
    "changes",
    [
        {"explanation": "friction"},
        {"explained_tolerance": (0.5,)},
        {**FRICTION, "explained_tolerance": (np.inf,)},
        {**FRICTION, "explained_tolerance": (np.nan,)},
        {**FRICTION, "explained_tolerance": (0.1,)},  # not wider
        {**FRICTION, "explained_tolerance": (0.5, 0.09)},
        {**FRICTION, "explained_tolerance": (0.5,), "relative": 0.5},
        {"absolute": (np.inf,)},
        {"absolute": (-0.1,)},
        {"relative": np.nan},
    ],
)
def test_explanation_without_a_wider_finite_bound_is_refused(changes: dict[str, Any]) -> None:
    with pytest.raises(InvalidValueError, match="toleranc"):
        verdict_of([1.0, 2.0], [1.0, 2.0], **changes)


def test_numbers_that_do_not_stand_beside_each_other_are_refused() -> None:
    check = replace(CATALOGUE.experiments[6].checks[0], unit=("rad",), absolute=(1.0,))
    check.require_sizes(np.zeros(3), np.zeros(3))
    with pytest.raises(ShapeError, match="measured values"):
        check.require_sizes(np.zeros(3), np.zeros(1))
    with pytest.raises(ShapeError, match="units"):
        replace(check, unit=("rad", "m")).require_sizes(np.zeros(3), np.zeros(3))
    with pytest.raises(ShapeError, match="absolute tolerances"):
        replace(check, absolute=(1.0, 1.0)).require_sizes(np.zeros(3), np.zeros(3))
    explained = replace(check, explanation="friction", explained_tolerance=(2.0, 2.0))
    with pytest.raises(ShapeError, match="explained tolerances"):
        explained.require_sizes(np.zeros(3), np.zeros(3))


def test_figure_whose_measurement_has_another_size_is_not_judged() -> None:
    experiment = CATALOGUE.experiments[6]
    measured = replace(experiment.checks[0].measure, arguments={"signal": "joint_error", "components": [2]})
    wrong = replace(experiment, checks=(replace(experiment.checks[0], measure=measured),))
    recorded = {name: record_run(replace(CATALOGUE.runs[name], duration=0.002)) for name in experiment.runs}
    with pytest.raises(ShapeError, match="measured values of check 'pd_sag'"):
        judge(wrong, recorded)


def test_answers_are_filled_where_all_their_checks_were_made() -> None:
    experiment = CATALOGUE.experiments[6]
    verdict = replace(verdict_of([0.0] * 3, [0.0, -1e-9, -0.0192]), check=experiment.checks[0])
    filled = fill(CATALOGUE.answers, [FigureOutcome(experiment, {}, (verdict,))])
    assert [answer.question for answer, _ in filled] == ["6.2"]
    assert "-0.01920 rad" in filled[0][1]
    assert "{" not in filled[0][1]


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ([1.23456], "1.235"),
        ([1.0, 1.0, 1.0], "1"),
        ([0.5, -0.25], "(0.5, -0.25)"),
        ([1.23456e-5, 0.0], "(1.2e-05, 0)"),
        ([-1e-15], "0"),
        ([-0.0], "0"),
        ([np.nan], "nan"),
        ([np.inf], "inf"),
    ],
)
def test_numbers_are_shown_without_noise(values: list[float], text: str) -> None:
    assert show(np.array(values)) == text


@pytest.mark.parametrize(
    ("unit", "text"),
    [(("rad",), "rad"), (("rad", "m", "rad"), "rad, m, rad"), (("m", "m", "m"), "m"), (("m",) * 2, "m")],
)
def test_unit_is_given_for_each_number_where_they_differ(unit: tuple[str, ...], text: str) -> None:
    assert unit_of(replace(CHECKS[0], unit=unit)) == text


class Counting:
    """A policy whose state is two arrays; the first one counts its calls."""

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = True
    ) -> tuple[Any, Any]:
        count = 0.0 if state is None else state[0][0]
        return -observation, (np.array([count + 1.0, -count]), np.array([[7.0]]))


def test_recorder_passes_actions_on_and_keeps_the_named_states() -> None:
    recorder = StateRecorder(Counting(), ("memory",))
    state = None
    for step in range(3):
        action, state = recorder.predict(np.array([step, 2.0]), state)
        np.testing.assert_array_equal(action, [-step, -2.0])
    fields_ = recorder.fields()
    assert list(fields_) == ["memory"]
    np.testing.assert_array_equal(fields_["memory"], [[np.nan, np.nan], [1, 0], [2, -1], [3, -2]])


def test_recorder_keeps_only_named_states_and_refuses_those_that_do_not_exist() -> None:
    assert StateRecorder(Counting(), ()).fields() == {}
    recorder = StateRecorder(Counting(), ("a", "b", "c"))
    recorder.predict(np.zeros(2))
    with pytest.raises(InvalidValueError, match="at most 2"):
        recorder.fields()


def test_run_has_the_settings_that_it_declares() -> None:
    goal = [0.1, -0.1, 0.2]
    run = replace(CATALOGUE.runs["link_mass_errors"], duration=0.01, seed=3)
    at_goal = record_run(replace(run, keywords={"reference": "constant"}, options={"goal": goal})).rollout
    np.testing.assert_array_equal(at_goal.fields["desired_joint_position"][-1], goal)
    recorded = record_run(replace(run, unlimited_torque=True))
    rollout = recorded.rollout
    assert (rollout.scenario, rollout.seed) == ("report", 3)
    assert rollout.period == pytest.approx(1e-3)
    assert len(rollout.torque) == 10
    assert recorded.settings["model"].link_mass == pytest.approx((0.9, 0.5, 0.7))
    assert recorded.gains_source.startswith("gains of figures 11")
    assert np.abs(rollout.torque).max() < 5e3
    stiff = replace(run, overrides={"proportional_gain": 1e6})
    assert np.abs(record_run(stiff).rollout.torque[0]).max() == pytest.approx(1e4)  # a hundred times 100 N
    assert np.abs(record_run(replace(stiff, unlimited_torque=True)).rollout.torque[0]).max() > 2e4
    exact = record_run(replace(run, overrides={})).rollout
    assert not np.allclose(exact.torque, rollout.torque, rtol=1e-2)


@pytest.mark.parametrize(
    ("changes", "word"),
    [({"environment": "PRP-X-v0"}, "PRP-X"), ({"controller": "x"}, "'x'"), ({"gains": "y"}, "'y'")],
)
def test_run_with_a_name_that_does_not_exist_is_refused(changes: dict[str, Any], word: str) -> None:
    with pytest.raises(UnknownNameError, match=word):
        record_run(replace(CATALOGUE.runs["pd"], **changes))


def test_number_is_predicted_as_it_stands() -> None:
    np.testing.assert_array_equal(Number((1.0, -2.0), "somewhere").compute(), [1.0, -2.0])
