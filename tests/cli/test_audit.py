"""`prp-gym audit`: which policies are run, what is written and printed, and that a contradiction fails."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from prp_gym.cli import audit as command
from prp_gym.cli.main import app
from prp_gym.comparison.agents import find_agents
from prp_gym.comparison.audit_jobs import RandomGainsJob, UnawareJob, list_audit_jobs
from prp_gym.comparison.jobs import ControllerJob, VariedJob
from prp_gym.runs.choice import GainsChoice
from prp_gym.runs.controllers import Controllers
from prp_gym.runs.selection import Selection

RUNNER = CliRunner()
ID = "PRP-Adaptive-v0"


def selection(environment_id: str) -> Selection:
    return Selection.of([environment_id], ["realistic"], [], GainsChoice())


def test_audit_has_all_kinds_of_policies_and_at_least_forty() -> None:
    jobs = list_audit_jobs(selection("PRP-Force-v0"), find_agents(["PRP-Force-v0"], []), 1, 0, 30)
    names = [job.name for job in jobs]
    assert len(set(names)) == len(names) >= 40
    unaware = {job.floor for job in jobs if isinstance(job, UnawareJob)}
    assert unaware == {"zero_torque", "hold", "hover", "press_the_stop", "maximum_torque"}
    drawn = [job for job in jobs if isinstance(job, RandomGainsJob)]
    assert len(drawn) == 30
    assert {job.controller for job in drawn} >= {"force_inner_position", "parallel_force_position"}
    assert any("force_feedforward" in name for name in names)
    assert any("agent" in name for name in names)


def test_audit_has_every_controller_also_with_its_other_stable_gains() -> None:
    pd, inverse = "joint_pd", "joint_inverse_dynamics"
    chosen = Selection.of(["PRP-JointTracking-v0"], ["realistic"], [pd, inverse], GainsChoice())
    jobs = list_audit_jobs(chosen, [], 1, 0, 2)
    compared = [job.controller.name for job in jobs if isinstance(job, ControllerJob)]
    varied = [(job.controller.name, job.controller.gains.name) for job in jobs if isinstance(job, VariedJob)]
    assert compared == [pd, inverse]
    # figures of joint_pd are unstable at 500 Hz
    assert varied == [
        *((pd, gains) for gains in ("report", "tuned_50hz")),
        *((inverse, gains) for gains in ("report", "figures", "fast", "tuned_50hz")),
    ]


def test_random_gains_differ_between_draws_and_repeat() -> None:
    def scores(draw: int) -> list[float]:
        job = RandomGainsJob("joint_pd", draw, ID, "realistic", 1, 0)
        return [float(np.ravel(value)[0]) for value in job.run(Controllers())["episodes"]["score"]]

    assert scores(0) == scores(0)
    assert scores(0) != scores(1)


def test_too_few_policies_fail_and_the_results_are_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    jobs = [
        UnawareJob(ID, "realistic", name, 500.0, 2, 0) for name in ("zero_torque", "hold", "maximum_torque")
    ]
    monkeypatch.setattr(command, "list_audit_jobs", lambda *_: jobs)
    options = ["audit", "--env", ID, "--episodes", "2", "--jobs", "1", "--output", str(tmp_path / "audit")]
    result = RUNNER.invoke(app, options)
    assert result.exit_code == 1, result.output
    assert "rank correlation" in result.output
    assert "maximum" in result.output
    (audit,) = json.loads((tmp_path / "audit/results.json").read_text())["audits"]
    assert audit["policies"] == ["zero_torque", "hold", "maximum_torque"]
    assert {item["metric"] for item in audit["findings"] if item["required"]} == {
        "response_settling_time",
        "unsettled",
    }
    assert not audit["holds"]
