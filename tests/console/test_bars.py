"""Progress in a terminal: bars within its width."""

import io
import re

from rich.console import Console

from prp_gym.console.activity import Activity
from prp_gym.console.bars import Bars


def shown(width: int) -> str:
    """What a terminal shows last of a progress with a long name, half of which is done."""
    stream = io.StringIO()
    console = Console(file=stream, force_terminal=True, width=width, color_system=None)
    with Bars(console, "evaluating", 40, 10) as bars:
        bars.advance(10)
        bars.run(
            [Activity("PRP-ForcePosition-v0_realistic_operational_inverse_dynamics"), Activity("other", 0.5)]
        )
        bars.run([Activity("PRP-ForcePosition-v0_realistic_operational_inverse_dynamics")])
        bars._bars.refresh()
    return stream.getvalue()


def test_bars_show_what_is_done_what_runs_and_the_time_that_is_left() -> None:
    text = shown(120)
    assert "20/40" in text
    assert re.search(r"\d s, \d+ s left", text)
    assert "PRP-ForcePosition-v0_realistic_operational_inverse_dynamics" in text
    assert "0/?" not in text  # what is not known is left out


def test_bars_fit_80_columns() -> None:
    lines = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown(80)).replace("\r", "\n").splitlines()
    assert max(map(len, lines)) <= 80
    assert any(line.lstrip().startswith("PRP-Force") for line in lines)


def test_line_of_a_long_training_is_not_broken_at_80_columns() -> None:
    stream = io.StringIO()
    console = Console(file=stream, force_terminal=True, width=80, color_system=None)
    with Bars(console, "computing the statistics and drawing", 3_000_000) as bars:
        bars.advance(1_200_000)
        bars.run([Activity("PRP-ForcePosition-v0 ppo_residual-joint_inverse_dynamics seed 0", 0.4)])
        task = bars._bars.tasks[0]
        task.start_time = bars._bars.get_time() - 30_000
        bars._bars.refresh()
    text = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", stream.getvalue())
    assert re.search(r"1200000/3000000 8 h 20 min, 12 h 30 min left *$", text, re.MULTILINE)
