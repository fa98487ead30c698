"""The figure of an episode: its panels, units, limits, phases of contact, and cues beside colour."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from prp_gym.evaluation import Rollout
from prp_gym.figures.episode_figure import contact_spans, draw_episode
from prp_gym.figures.episode_panels import ACTUAL, MODEL, REFERENCE, episode_panels
from prp_gym.palette import PALETTE
from tests.support.synthetic_rows import KINDS, episode

UNITS = {
    "joint": ["[rad]", "[mrad]", "[m]", "[mm]", "[N m]", "[N]", "[1]"],
    "link": ["[rad]", "[mrad]", "[N m]", "[1]"],
    "pose": ["[m]", "[mm]", "[rad]", "[mrad]", "[N m]", "[N]", "[1]"],
    "model": ["[m]", "[mm]", "[rad]", "[mrad]", "[N m]", "[N]", "[N]", "[1]"],
    "force": ["[m]", "[mm]", "[rad]", "[mrad]", "[N m]", "[N]", "[N]", "[1]"],
}


def rollout_of(kind: str) -> Rollout:
    joints = KINDS[kind]["joint_velocity"].shape[-1]
    return episode(fields=KINDS[kind], torque_limit=np.array([50.0, 100.0, 10.0])[:joints])


def shown_axes(figure: Any) -> list[Any]:
    return [axes for axes in figure.axes if axes.axison]


@pytest.mark.parametrize("kind", KINDS)
def test_task_has_the_panels_that_it_needs_with_units_on_every_axis(kind: str) -> None:
    axes = shown_axes(draw_episode(rollout_of(kind)))
    assert [
        own.get_ylabel().split()[-1] if "N m" not in own.get_ylabel() else "[N m]" for own in axes
    ] == UNITS[kind]
    labelled = [own for own in axes if own.get_xlabel()]
    assert [own.get_xlabel() for own in labelled] == ["time [s]"] * 2
    assert all(any(tick.label1.get_visible() for tick in own.xaxis.get_major_ticks()) for own in labelled)


def test_errors_are_to_the_model_where_there_is_one_in_thousandths() -> None:
    panels = episode_panels(rollout_of("model"))
    error = next(panel for panel in panels if panel.quantity.startswith("error to target model\n[mm]"))
    np.testing.assert_allclose(error.curves[2].values, 20.0, rtol=1e-12)  # 20 mm along z
    to_reference = episode_panels(rollout_of("pose"))[1]
    assert to_reference.quantity == "error to reference\n[mm]"
    np.testing.assert_allclose(to_reference.curves[0].values, [100.0, 3.0, 3.0], rtol=1e-12)


def test_torque_panels_hold_the_limits_of_their_joints() -> None:
    torque, force = (panel for panel in episode_panels(rollout_of("joint")) if panel.limits)
    assert [value for _, value in torque.limits] == [50.0, 10.0]
    assert [value for _, value in force.limits] == [100.0]
    axes = shown_axes(draw_episode(rollout_of("joint")))
    text = [text.get_text() for own in axes for text in own.get_legend().texts]
    assert "limit of $\\tau_3$: ±10" in text


def test_limit_that_is_reached_is_drawn_to_both_sides() -> None:
    pushing = replace(rollout_of("link"), applied_torque=np.array([[49.0], [-50.0]]))
    axes = next(own for own in draw_episode(pushing).axes if "N m" in own.get_ylabel())
    levels = [
        np.asarray(line.get_ydata()).tolist() for line in axes.get_lines() if line.get_linestyle() == "-."
    ]
    assert levels == [[-50.0, -50.0], [50.0, 50.0]]


def test_contact_is_marked_from_touch_to_release() -> None:
    force = np.zeros((6, 3))
    force[[1, 2, 4], 0] = 2.0
    touching = episode(
        fields={"joint_velocity": np.zeros((6, 3)), "contact_force": force}, reward=np.zeros(5)
    )
    assert contact_spans(touching) == [pytest.approx((0.01, 0.02)), pytest.approx((0.04, 0.04))]
    assert contact_spans(rollout_of("joint")) == []
    legend = draw_episode(rollout_of("force")).legends[0]
    assert [text.get_text() for text in legend.get_texts()] == [
        *("actual", "reference", "actuator limit", "tip in contact"),
    ]


def test_colour_is_never_the_only_cue() -> None:
    for axes in shown_axes(draw_episode(rollout_of("model"))):
        lines = [line for line in axes.get_lines() if len(line.get_xdata())]
        cues = [(line.get_linestyle(), line.get_marker()) for line in lines]
        shown = [cue for cue in cues if cue[0] == "-"]
        assert len(set(shown)) == len(shown)  # components differ by their markers
        assert {cue[0] for cue in cues} <= {"-", "--", ":", "-."}
        assert {line.get_color() for line in lines} <= set(PALETTE)


def test_roles_of_the_curves_are_those_of_the_task() -> None:
    def roles(kind: str) -> set[str]:
        return {curve.role for panel in episode_panels(rollout_of(kind)) for curve in panel.curves}

    assert roles("model") == {ACTUAL, REFERENCE, MODEL}
    assert roles("force") == {ACTUAL, REFERENCE}


def test_episode_that_diverged_says_so_in_its_title() -> None:
    title = draw_episode(replace(rollout_of("joint"), diverged=True), "joint_pd").get_suptitle()
    assert title == "PRP-JointTracking-v0, scenario randomized, seed 0, joint_pd: mean reward 0.500, diverged"
