"""`prp-gym audit`: which policies are run, what is written and printed, and that a contradiction fails."""

import json
from functools import partial
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from typer.testing import CliRunner

from prp_gym.agents.policy import agent_file
from prp_gym.cli import audit as command
from prp_gym.cli.main import app
from prp_gym.comparison.agents import find_agents
from prp_gym.comparison.audit_jobs import AuditJob, RandomGainsJob, UnawareJob, list_audit_jobs
from prp_gym.comparison.jobs import ControllerJob, VariedJob
from prp_gym.runs.choice import GainsChoice
from prp_gym.runs.controllers import Controllers
from prp_gym.runs.selection import Selection
from prp_gym.tasks.setup import COMPILED, ENGINES, MUJOCO
from tests.cli.test_engine import SAME
from tests.support.compiler import needs_compiler
from tests.support.synthetic_agents_to_compare import save

RUNNER = CliRunner()
ID = "PRP-Adaptive-v0"
TRACKING = "PRP-JointTracking-v0"


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


@needs_compiler
def test_audit_runs_every_policy_with_the_engine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Over policies with stable control, for which the engines agree; the command fails, as they are few."""
    compared = ("joint_pd_controller", "joint_pd_tuned_50hz_varied", "joint_pd_random_0", "_agent_", "hold_")

    def some(*given: Any) -> list[AuditJob]:
        return [job for job in list_audit_jobs(*given) if any(part in job.name for part in compared)]

    monkeypatch.setattr(gymnasium, "make", partial(gymnasium.make, duration=0.2))
    monkeypatch.setattr(command, "list_audit_jobs", some)
    monkeypatch.setattr(agent_file, "TRAINED", tmp_path / "trained")
    save(tmp_path / "trained" / TRACKING / "ppo_torque_seed_0", 0)
    given = ["audit", "--jobs", "1", "--env", TRACKING, "--episodes", "2", "--draws", "1"]
    found = {}
    for engine in ENGINES:
        result = RUNNER.invoke(app, [*given, "--engine", engine, "--output", str(tmp_path / engine)])
        assert result.exit_code == 1, result.output
        titled = "criteria of the tasks, engine compiled" in " ".join(result.stdout.split())
        assert titled is (engine == COMPILED)
        content = json.loads((tmp_path / engine / "results.json").read_text(encoding="utf-8"))
        assert [audit["engine"] for audit in content["audits"]] == [engine]
        found[engine] = content["evaluations"]
        assert [row["engine"] for row in found[engine]] == [engine] * len(compared)
    for one, other in zip(found[MUJOCO], found[COMPILED], strict=True):
        assert one["policy"] == other["policy"]
        scores = [[score for (score,) in row["episodes"]["score"]] for row in (one, other)]
        assert scores[1] == pytest.approx(scores[0], abs=SAME), one["policy"]
