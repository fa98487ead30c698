"""What a step is made of, and what an environment takes of memory."""

import time
from typing import Any

import gymnasium
import pytest

from bench import costs, goals, memory, single
from bench.rounds import ALL_CORES, CONTACT, FREE, FULL, QUICK


@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("part", ["physics", "task", "wrapper"])
def test_time_is_that_of_the_part_that_takes_it(
    part: str, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: Any = gymnasium.make(FREE) if count == 1 else gymnasium.make_vec(FREE, count)
    inner = made.unwrapped
    owner, name = {
        "physics": (type(inner.physics), "advance"),
        "task": (type(inner._loop), "step_alone" if count == 1 else "_advance"),
        "wrapper": (type(inner), "step"),
    }[part]
    call = getattr(owner, name)

    def slow(*arguments: Any) -> Any:
        time.sleep(0.005)
        return call(*arguments)

    monkeypatch.setattr(owner, name, slow)
    parts = costs.Parts(costs.Condition(FREE, 500.0, count, 1), QUICK)
    seconds = parts.measure()
    parts.close()
    whole = {name: seconds.pop(name) for name in ("step", "controller")}["step"]
    assert sum(seconds.values()) == pytest.approx(whole)  # rounding
    assert min(seconds.values()) > 0.0
    assert count * seconds[part] > 0.005
    assert max(seconds, key=lambda name: seconds[name]) == part


def test_steps_are_split_where_goals_are_about() -> None:
    found = {tuple(vars(condition).values()) for condition in costs.conditions(FULL)}
    for frequency in single.FREQUENCIES:
        assert (FREE, frequency, 1, 1) in found
        sizes = {*goals.GROWTH_SIZES, *goals.BARE_SIZES, goals.SYNC_SIZE}
        assert {(FREE, frequency, count, ALL_CORES) for count in sizes} <= found


def test_memory_is_measured_at_every_size_in_free_space(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "_in_process", lambda condition: 1000 + 10 * (condition[1] - 1))
    rows = memory.measure(FULL)
    assert [row["num_envs"] for row in rows if row["environment"] == FREE] == [8, 64, 256, 1024, 4096]
    assert [row["num_envs"] for row in rows if row["environment"] == CONTACT] == [64, 1024]
    assert {row["bytes_per_env"] for row in rows} == {10.0}
