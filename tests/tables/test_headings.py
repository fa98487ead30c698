"""Headings in lines: broken where they may be, with a hyphen where a word is."""

import pytest

from prp_gym.tables.headings import fold_heading, fold_name, longest_piece, without_breaks

HEADING = "force set\u00adtling time"


@pytest.mark.parametrize(
    ("width", "lines"),
    [
        (5, ["force", "set-", "tling", "time"]),
        (9, ["force", "settling", "time"]),
        (10, ["force set-", "tling time"]),
        (14, ["force settling", "time"]),
        (19, ["force settling time"]),
    ],
)
def test_heading_takes_as_few_lines_as_its_width_allows(width: int, lines: list[str]) -> None:
    assert fold_heading(HEADING, width) == lines


def test_hyphen_of_the_word_itself_stays() -> None:
    assert fold_heading("steady-state error", 7) == ["steady-", "state", "error"]
    assert fold_heading("steady-state error", 12) == ["steady-state", "error"]


def test_longest_piece_counts_the_hyphen() -> None:
    assert longest_piece(HEADING) == 5
    assert longest_piece("un\u00adset\u00adtled") == 4


def test_heading_in_one_line_has_no_breaks() -> None:
    assert without_breaks(HEADING) == "force settling time"


def test_names_of_controllers_are_broken_at_underscores() -> None:
    assert fold_heading("operational_inverse_dynamics", 12) == ["operational_", "inverse_", "dynamics"]
    assert fold_name("(0.12, -0.5, 1e-05)", 8) == "(0.12,\n-0.5,\n1e-05)"
    assert fold_name("operational_inverse_dynamics (report)", 28) == "operational_inverse_dynamics\n(report)"
