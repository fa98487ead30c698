"""The table for the terminal: content of its cells, and a width of at most 120 columns for every task."""

import itertools
from functools import cached_property
from io import StringIO

import gymnasium
import numpy as np
import pytest
from rich.console import Console

from prp_gym import list_envs
from prp_gym.baselines import BASELINES, list_baselines, make_baseline
from prp_gym.errors import InvalidValueError, UnknownNameError
from prp_gym.evaluation import METRICS, Evaluation, Metric, evaluate
from prp_gym.evaluation.scoring import scoring_of
from prp_gym.evaluation.table import Row, evaluation_table
from tests.support.synthetic_episodes import Array, make_rollout
from tests.support.synthetic_rows import IDS, KINDS, LONGEST_NAME, episode, joints, row, row_of, tip

WIDTH = 120


def render(title: str, *rows: Row, kind: str = "joint") -> list[str]:
    return render_task(IDS[kind], title, *rows)


def render_task(environment_id: str, title: str, *rows: Row) -> list[str]:
    console = Console(file=StringIO(), width=WIDTH, force_terminal=False, color_system=None)
    console.print(evaluation_table(title, rows, scoring_of(environment_id).columns))
    assert isinstance(console.file, StringIO)
    return console.file.getvalue().splitlines()


def split(*rows: Row, kind: str = "joint") -> tuple[list[str], list[str]]:
    """The lines above the rule, without the title, and those below it."""
    lines = render("title", *rows, kind=kind)
    rule = next(index for index, line in enumerate(lines) if "───" in line)
    return lines[1:rule], [line for line in lines[rule + 1 :] if line.strip()]


def body(*rows: Row, kind: str = "joint") -> list[str]:
    return split(*rows, kind=kind)[1]


def cells(*rows: Row, kind: str = "joint") -> list[str]:
    """What stands between the interval and the compute time, in a single row."""
    (line,) = body(*rows, kind=kind)
    return line.split()[3:-1]


def test_cells_of_a_joint_task_show_the_known_values() -> None:
    (line,) = body(row(fields=joints([-0.012, 0.0034, 0.5]), applied_torque=np.full((2, 3), 50.0)))
    # scores ½ in every episode; RMSE over three samples, the first with the whole step; the steady error
    # is that of the last sample; joints 1 and 2 overshoot by 0.6 and 0.34 cm at the tip, after a move of
    # 56.3 cm; 3·50 W for 0.02 s
    assert line.split() == [
        LONGEST_NAME,
        *("0.500", "0.500-0.500"),
        *("577", "58", "707"),
        *("-12", "3.4", "500"),
        *("never", "1.2", "3", "0", "42"),
    ]


def test_cells_of_a_single_joint_show_one_number() -> None:
    # RMSE of 1, 0.1 and 0.1 rad
    assert cells(row(fields=joints([0.1]))) == ["583", "100", "never", "0", "0", "0"]
    head = "\n".join(split(row(fields=joints([0.1])))[0])
    assert "mrad" in head.split()
    assert "mm" not in head.split()


def test_cells_of_a_pose_task_show_the_known_values() -> None:
    # RMSE of 100, 3 and 3 mm, of 0, 4 and 4 mrad; 3 mm before the goal, or 1 mm beyond it
    assert cells(row(fields=KINDS["pose"]), kind="pose") == ["58", "3.3", "3", "0", "0", "0"]
    beyond = tip((-0.001, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert cells(row(fields=beyond), kind="pose") == ["58", "0", "1", "1", "0", "0"]


def test_cells_of_a_task_with_a_reference_model_show_the_known_values() -> None:
    # 20 mm and 5 mrad from the model; 5 N once, then lost; (0.3 + 0.4) W, half a sample to either side
    assert cells(row(fields=KINDS["model"]), kind="model") == ["20", "5", "5", "1", "7", "0", "0"]


def test_cells_of_a_force_task_show_the_known_values() -> None:
    # force errors 2, -2 and 2 N, a peak of 5 N where 2 N are desired; before them the orientation's RMSE
    assert cells(row(fields=KINDS["force"]), kind="force") == [
        "3.3",
        "2",
        "2",
        "250",
        "1",
        "0",
        "0",
    ]


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.0, "0"),
        (4e-6, "0"),
        (5.7e-5, "0.06"),
        (3.21e-3, "3.2"),
        (-0.0123, "-12"),
        (2.34, "2340"),
        (9.9994, "9999"),
        (-9.9994, "-9999"),
        (9.9996, "1e4"),
        (-2.3e4, "-2e7"),
    ],
)
def test_errors_are_shown_in_thousandths_as_far_as_they_matter(value: float, shown: str) -> None:
    (line,) = body(row(fields=joints([value, 0.0, 0.0])))
    assert line.split()[6] == shown


@pytest.mark.parametrize(("time", "shown"), [(3e-7, "0"), (7.6e-6, "8"), (1.2e-3, "1200"), (0.7, "7e5")])
def test_compute_time_is_shown_in_whole_microseconds(time: float, shown: str) -> None:
    fast = make_rollout(joints(), duration=0.02, compute_time=np.full(2, time))
    (line,) = body(row_of("controller", Evaluation([fast], 0)))
    assert line.split()[-1] == shown


def test_what_an_episode_does_not_have_is_a_dash() -> None:
    moving = joints()
    moving["desired_joint_position"][0, 0] = 0.5
    # overshoot of a moving reference; the steady error is there
    assert cells(row(fields=moving))[3:] == ["0", "0", "0", "0.01", "-", "0", "0"]
    assert cells(row(diverged=True)) == ["-", "-", "never", "-", "-", "-"]


def test_what_an_environment_does_not_have_is_no_column() -> None:
    bare = {"joint_velocity": joints()["joint_velocity"]}
    assert cells(row(fields=bare)) == ["0", "0"]
    head = " ".join(split(row(fields=bare))[0]).split()
    assert {"settle", "RMSE", "mm", "N"}.isdisjoint(head)


def test_row_without_a_metric_of_another_row_has_a_dash() -> None:
    lines = body(row("a"), row("b", fields={"joint_velocity": joints()["joint_velocity"]}))
    assert lines[1].split()[3:] == ["-", "-", "-", "-", "0", "0", "42"]


def test_metric_that_a_table_cannot_show_is_refused() -> None:
    with pytest.raises(UnknownNameError, match=r"unknown metric 'joint_rms'\. Did you mean 'joint_rmse'"):
        evaluation_table("title", [row()], ["joint_rms"])
    with pytest.raises(InvalidValueError, match="'torque_rms'; allowed: one that declares a column"):
        evaluation_table("title", [row()], ["energy", "torque_rms"])


def test_table_shows_the_metrics_that_are_named_in_their_order() -> None:
    console = Console(file=StringIO(), width=WIDTH, force_terminal=False, color_system=None)
    console.print(evaluation_table("title", [row(fields=joints([0.1]))], ["saturation", "joint_rmse"]))
    assert isinstance(console.file, StringIO)
    assert console.file.getvalue().splitlines()[-2].split()[3:-1] == ["0", "583"]


SHOWN = [metric for metric in METRICS.values() if metric.column is not None]


PREFIXES = {"m": 1e-3, "": 1.0}


@pytest.mark.parametrize("metric", SHOWN, ids=lambda metric: metric.name)
def test_scale_of_a_column_leads_from_the_metrics_units_to_the_shown_ones(metric: Metric) -> None:
    column = metric.column
    assert column is not None
    for shown, own in zip(column.units, metric.units, strict=True):
        assert shown.endswith(own)
        assert column.scale * PREFIXES[shown.removesuffix(own)] == pytest.approx(1.0, rel=1e-12)


def test_single_episode_has_no_interval() -> None:
    (line,) = body(row_of("controller", Evaluation([episode()], 0)))
    assert "1 episode" in line


def direct(controller: str, evaluation: Evaluation) -> Row:
    """A row whose numbers were never written."""
    count = len(evaluation.rollouts)
    return Row(controller, count, evaluation.summary, evaluation.median, evaluation.compute_time)


@pytest.mark.parametrize("kind", KINDS)
def test_table_of_records_read_back_is_that_of_the_evaluations(kind: str) -> None:
    evaluations = {
        "lame": Evaluation([episode(seed, KINDS[kind], diverged=True) for seed in range(3)], 0),
        "fast": Evaluation([episode(seed, KINDS[kind]) for seed in range(3)], 0),
        "once": Evaluation([episode(fields=KINDS[kind], reward=np.full(2, 1 / 3))], 0),
    }
    medians = np.concatenate([value for own in evaluations.values() for value in own.median.values()])
    assert np.isnan(medians).any()
    assert np.isinf(medians).any() or kind not in ("pose", "force")
    shown = render("title", *(direct(*item) for item in evaluations.items()), kind=kind)
    assert render("title", *(row_of(*item) for item in evaluations.items()), kind=kind) == shown


def test_best_score_comes_first() -> None:
    rows = [row(name, reward=np.full(2, worth)) for name, worth in (("b", 0.2), ("a", 0.9), ("c", 0.5))]
    assert [line.split()[0] for line in body(*rows)] == ["a", "c", "b"]


UNITS = {
    "joint": ["mrad", "mm", "mrad", "mrad", "mm", "mrad", "s", "%", "J", "%", "µs"],
    "link": ["mrad", "mrad", "s", "%", "J", "%", "µs"],
    "pose": ["mm", "mrad", "mm", "%", "J", "%", "µs"],
    "model": ["mm", "mrad", "N", "1", "mJ", "J", "%", "µs"],
    "force": ["mrad", "N", "N", "%", "1", "J", "%", "µs"],
}


@pytest.mark.parametrize("kind", KINDS)
def test_title_and_every_unit_stand_above_the_numbers(kind: str) -> None:
    assert render("PRP-Task-v0, scenario realistic", row())[0].strip() == "PRP-Task-v0, scenario realistic"
    head, _ = split(row(fields=KINDS[kind]), kind=kind)
    assert head[-1].split() == ["controller", "score", "interval", *UNITS[kind]]


class Widest(Evaluation):
    """An evaluation whose medians take as much room as there can be, signs included."""

    @cached_property
    def median(self) -> dict[str, Array]:
        scales = {metric.name: metric.column.scale for metric in SHOWN if metric.column}
        signs = {"steady_state_error": -1.0, "steady_state_force_error": -1.0}
        return {
            name: np.full_like(values[0], 9999.0 * signs.get(name, 1.0) / scales.get(name, 1.0))
            for name, values in self.metrics.items()
        } | {"saturation": np.array([100.0])}

    @property
    def compute_time(self) -> float:
        return 0.009999


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_is_cut_off_at_120_columns(kind: str) -> None:
    episodes = [episode(seed, KINDS[kind]) for seed in range(3)]
    rows = row_of(LONGEST_NAME, Widest(episodes, 0)), row("other", fields=KINDS[kind])
    lines = render("title", *rows, kind=kind)
    assert max(len(line.rstrip()) for line in lines) <= WIDTH
    assert not any("…" in line for line in lines)
    (widest,) = (line.split() for line in lines if LONGEST_NAME in line)
    plain = body(row(fields=KINDS[kind]), kind=kind)[0].split()
    assert widest[:3] == plain[:3]
    assert len(widest) == len(plain)
    assert {number.removeprefix("-") for number in widest[3:]} == {"9999", "100"}


def test_no_controller_has_a_longer_name_than_the_table_was_tried_with() -> None:
    assert max(map(len, BASELINES)) <= len(LONGEST_NAME)


@pytest.mark.parametrize(
    ("environment_id", "scenario"),
    list(zip(list_envs(), itertools.cycle(("report", "randomized")), strict=False)),
)
def test_table_of_real_evaluations_is_whole(environment_id: str, scenario: str) -> None:
    env = gymnasium.make(environment_id, scenario=scenario, duration=0.04)
    controllers = list_baselines(env.get_wrapper_attr("observation_layout"))
    rows = [
        row_of(controller, evaluate(make_baseline(controller, env), env, episodes=2))
        for controller in controllers
    ]
    env.close()
    lines = render_task(environment_id, f"{environment_id}, scenario {scenario}", *rows)
    assert not any("…" in line for line in lines)
    for controller in controllers:
        assert sum(controller in line for line in lines) == 1
