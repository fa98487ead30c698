"""The plots show the signals, and the predicted lines agree with the simulation where theory is exact."""

import numpy as np
import pytest

from prp_gym.robot.arrays import Array
from prp_gym.viewing.disturbance import Disturbance
from prp_gym.viewing.plot import Plot
from prp_gym.viewing.plots import make_plots
from prp_gym.viewing.predicted_motion import slide_direction
from tests.support.viewing_sessions import controller_session


def predicted(plot: Plot) -> list[Array]:
    return [line.values for line in plot.lines if line.kind == "predicted"]


def test_force_decays_as_predicted() -> None:
    session = controller_session("PRP-Force-v0", "parallel_force_position")
    session.advance(400)
    force, _, _ = make_plots(session)
    measured, desired, (line,) = force.lines[0].values, force.lines[1].values, predicted(force)
    assert force.unit == "N"
    from_half = ~np.isnan(line)
    assert from_half.sum() > 200
    deviation = np.abs(line - measured)[from_half] / desired[0]
    assert deviation.max() < 0.06  # the estimate of the stiffness is still settling
    assert deviation[-1] < 5e-3
    surface = session.inner.physics.surface()
    pressed = -session.signals.fields["contact_force"] @ surface.normal[0]
    assert measured == pytest.approx(pressed, abs=1e-12)


def test_fixed_force_gains_decay_with_the_slowest_mode() -> None:
    session = controller_session("PRP-Force-v0", "parallel_force_position", "report", "report")
    session.advance(1250)
    force, *_ = make_plots(session)
    (line,) = predicted(force)
    settled = force.time > 1.5  # the faster modes are over
    error = 1.0 - force.lines[0].values[settled]
    rate = np.polyfit(force.time[settled], np.log(np.abs(error)), 1)[0]
    expected = np.polyfit(force.time[settled], np.log(np.abs(1.0 - line[settled])), 1)[0]
    assert rate == pytest.approx(expected, rel=0.02)  # of a sampled loop


@pytest.mark.parametrize("controller", ["compliance", "impedance"])
def test_force_at_rest_is_that_of_two_springs(controller: str) -> None:
    session = controller_session("PRP-Compliance-v0", controller)
    session.advance(1500)
    force, displacement, _ = make_plots(session)
    (line,) = predicted(force)
    assert force.lines[0].values[-1] == pytest.approx(line[-1], rel=1e-3)  # a rest of the motion
    (model,) = predicted(displacement)
    assert displacement.lines[0].values[-1] == pytest.approx(model[-1], rel=1e-2)
    assert displacement.unit == "mm"


def test_impedance_follows_its_target_model() -> None:
    session = controller_session("PRP-Impedance-v0", "impedance", "report", "report")
    session.advance(1000)
    _, displacement, _ = make_plots(session)
    (model,) = predicted(displacement)
    assert np.abs(model).max() > 20.0
    assert displacement.lines[0].values == pytest.approx(model, abs=0.5)  # [mm], of a sampled loop


def test_inverse_dynamics_responds_as_a_second_order_system() -> None:
    session = controller_session("PRP-JointRegulation-v0", "joint_inverse_dynamics", "fast", "report", 1000.0)
    session.advance(500)
    errors, _ = make_plots(session)
    lines = predicted(errors)
    assert len(lines) == 3
    for measured, line in zip(errors.lines[:3], lines, strict=True):
        first = abs(line[0])
        assert measured.values == pytest.approx(line, abs=0.02 * first)  # of a sampled loop
    session.set_factor("bandwidth_joint_1", 0.5)
    session.advance(1)
    assert predicted(make_plots(session)[0]) == []  # no longer the response of one set of gains


def test_joint_torque_deflects_pd_control_as_predicted() -> None:
    session = controller_session("PRP-JointRegulation-v0", "joint_pd", scenario="report")
    session.advance(1000)
    session.disturb(Disturbance(2.5, torque=(1.0, 2.0, 0.5)))
    session.advance(1000)
    errors, _ = make_plots(session)
    for measured, line in zip(errors.lines[:3], predicted(errors), strict=True):
        assert measured.values[-1] == pytest.approx(line[-1], rel=1e-2)  # a rest of the motion


def test_force_along_the_slide_deflects_operational_pd_as_predicted() -> None:
    session = controller_session("PRP-PoseRegulation-v0", "operational_pd", scenario="report")
    session.advance(1000)
    direction = slide_direction(session.inner.physics.joint_position[0])
    session.disturb(Disturbance(2.0, tuple((20.0 * direction).tolist())))
    session.advance(700)
    errors, _ = make_plots(session)
    lines = {line.name: line.values[-1] for line in errors.lines}
    assert abs(lines["y"]) > 4.0  # mm
    for axis in "xy":
        assert lines[f"{axis}, predicted at rest: F/K_P"] == pytest.approx(lines[axis], rel=1e-3)


def test_torques_are_shares_of_the_limits() -> None:
    session = controller_session("PRP-Adaptive-v0", "adaptive")
    session.advance(50)
    *_, torque = make_plots(session)
    assert torque.lines[0].values == pytest.approx(
        session.signals.torque[:, 0] / session.inner.torque_limit[0]
    )
    assert {line.values[0] for line in torque.lines if line.kind == "limit"} == {1.0, -1.0}
