"""Every error is of one root, keeps its facts as attributes and says them in its message."""

import pickle
import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from prp_gym.errors import (
    AgentFileError,
    CheckpointError,
    CompilerError,
    DataDependentBranchError,
    DataFileError,
    DataTextError,
    EpisodeError,
    ErrorObservationError,
    FolderInUseError,
    GainsFileError,
    GeneratedCodeError,
    InvalidValueError,
    JointLimitError,
    MissingFieldError,
    MissingPackageError,
    NonFiniteError,
    OutputError,
    PluginError,
    PolicyOutputError,
    PortError,
    PRPError,
    RenderingError,
    RunFolderError,
    ShapeError,
    UnknownKeywordError,
    UnknownNameError,
    UnreachableError,
    UntraceableError,
    UserCodeError,
    shortened,
)

PROPERTY = settings(max_examples=50, deadline=None, derandomize=True)
NAMES = st.lists(st.text("abcdefgh_", min_size=3, max_size=12), min_size=1, max_size=6, unique=True)
CONTROLLERS = ("joint_pd", "joint_inverse_dynamics", "impedance", "admittance")
WITH_FACTS = [
    UnknownNameError("controller", "impedence", CONTROLLERS),
    ErrorObservationError("PRP-Force-v0", 50.0),
    UnknownKeywordError("the environment", "duratoin", ("duration", "scenario")),
    InvalidValueError("duration", -1.0, "above 0", "s"),
    ShapeError("action", (2,), "(3,)"),
    NonFiniteError("action", [0.0, float("nan"), 0.0]),
    JointLimitError("initial joint position", 2, 0.1, (-0.3, 0.0), "m"),
    UnreachableError((0.1, 0.0, 0.15), 0.3, ("too near",)),
    CheckpointError("checkpoint-000000000512", "the checksum of tensors.pt does not match"),
    RunFolderError("runs/seed_0", "it holds an unfinished run"),
    FolderInUseError("runs/seed_0", "process 12 on host since noon (prp-gym train)"),
    MissingFieldError("impedance", ("contact_force",), ("joint_position", "joint_velocity")),
    AgentFileError("agent.json", "is not a JSON file"),
    DataFileError("result.json", "is a directory", "Move it away"),
    DataTextError("YAML", "it has more than 32 levels"),
    GainsFileError("my.toml", "No such file or directory"),
    PluginError("my_tasks", "no such module", "my_tasks.py", 3),
    UserCodeError("my_controller.py", 12, "ValueError: no gains", "PRP-Force-v0"),
    PolicyOutputError("MyPolicy", "a list", (3,)),
    GeneratedCodeError("prp_reward", "/usr/bin/cc", "generated.c:3:1: error: expected ';'"),
    PortError("127.0.0.1", 8080, "it is in use"),
    OutputError("results", "read-only file system"),
    MissingPackageError("ray", "ray"),
]
WITHOUT_FACTS = [
    EpisodeError("step before reset"),
    RenderingError("no display"),
    UntraceableError("numpy.linalg.svd"),
    DataDependentBranchError("a branch on force > 0"),
    CompilerError("no compiler"),
]
EXAMPLES = [*WITH_FACTS, *WITHOUT_FACTS]


class WithoutText:
    def __repr__(self) -> str:
        raise RuntimeError("no text")


def nested(depth: int) -> list[object]:
    value: list[object] = []
    for _ in range(depth):
        value = [value]
    return value


ENDLESS: list[object] = []
ENDLESS.append(ENDLESS)
HUGE: dict[str, object] = {
    "text": "x" * 10**6,
    "text of numpy": np.str_("y" * 10**6),
    "bytes": b"z" * 10**6,
    "integer": 10 ** (sys.get_int_max_str_digits() + 1),
    "integers in a list": [10**6000] * 1000,
    "list": list(range(10**6)),
    "dictionary": dict.fromkeys(range(10**6)),
    "set": set(range(10**6)),
    "array": np.zeros(10**6),
    "array of many dimensions": np.zeros((3,) * 12),  # numpy itself would write out all of its corners
    "array of objects": np.array([WithoutText(), 10**6000], dtype=object),
    "no text": WithoutText(),
    "no text in a list": [[WithoutText()]],
    "list that holds itself": ENDLESS,
    "deep list": nested(10**4),
}


def class_name(error: object) -> str:
    return type(error).__name__


def every_class(root: type[PRPError] = PRPError) -> Iterator[type[PRPError]]:
    """The classes of this package below the root."""
    for item in root.__subclasses__():
        if item.__module__.startswith("prp_gym."):
            yield item
        yield from every_class(item)


def test_examples_cover_every_class_of_the_module() -> None:
    here = {item for item in every_class() if item.__module__ == "prp_gym.errors"}
    assert {type(error) for error in EXAMPLES} == here


@pytest.mark.parametrize("error", EXAMPLES, ids=class_name)
def test_code_that_does_not_know_the_package_can_catch_it(error: PRPError) -> None:
    assert isinstance(error, PRPError)
    of_a_state = (
        *(CheckpointError, CompilerError, EpisodeError, MissingPackageError, OutputError, PluginError),
        *(FolderInUseError, GeneratedCodeError, PortError, RenderingError, RunFolderError, UserCodeError),
    )
    assert isinstance(error, RuntimeError if isinstance(error, of_a_state) else ValueError)


@pytest.mark.parametrize("error", WITH_FACTS, ids=class_name)
def test_message_tells_every_fact(error: PRPError) -> None:
    message = str(error)
    for name, fact in vars(error).items():
        parts = fact if isinstance(fact, tuple) and name != "shape" else (fact,)
        for part in parts:
            shown = f"{part:.6g}" if isinstance(part, float) else str(part)
            assert shown in message, name


def test_unknown_name_suggests_the_nearest_and_lists_all_in_order() -> None:
    error = UnknownNameError("controller", "impedence", iter(CONTROLLERS))
    assert str(error) == (
        "unknown controller 'impedence'. Did you mean 'impedance'?"
        " Valid: admittance, impedance, joint_inverse_dynamics, joint_pd."
    )
    assert (error.kind, error.name, error.valid) == ("controller", "impedence", tuple(sorted(CONTROLLERS)))


def test_unknown_name_far_from_all_gets_no_suggestion() -> None:
    message = str(UnknownNameError("controller", "zzz", CONTROLLERS))
    assert "Did you mean" not in message
    assert "joint_pd" in message


@pytest.mark.parametrize("name", [None, 3, ("a", "b")])
def test_unknown_name_may_be_anything(name: object) -> None:
    assert repr(name) in str(UnknownNameError("controller", name, CONTROLLERS))


@pytest.mark.parametrize("value", HUGE.values(), ids=HUGE)
def test_message_about_any_value_is_short_and_quick(value: object) -> None:
    before = time.perf_counter()
    for error in (
        UnknownNameError("controller", value, CONTROLLERS),
        InvalidValueError("duration", value, "above 0", "s"),
        NonFiniteError("action", value),
        ShapeError("action", (3,) * 10**4, "(3,)"),
    ):
        assert len(str(error)) < 250
    assert time.perf_counter() - before < 1.0  # each takes some microseconds; the complete text, seconds


@pytest.mark.parametrize("value", [None, True, 0.1, -7, "fast", [1.0, float("nan")], (0.0, 1.0), {"a": [1]}])
def test_short_values_are_shown_as_they_are(value: object) -> None:
    assert shortened(value) == repr(value)


@pytest.mark.parametrize("width", [10, 40, 80])
def test_shortened_text_keeps_the_width(width: int) -> None:
    for value in HUGE.values():
        assert len(shortened(value, width)) <= width


def test_unknown_name_says_when_nothing_is_valid() -> None:
    assert str(UnknownNameError("scenario", "x", ())) == "unknown scenario 'x'. Valid: none."


@PROPERTY
@given(names=NAMES, data=st.data())
def test_name_with_a_letter_too_many_gets_a_valid_one_suggested(
    names: list[str], data: st.DataObject
) -> None:
    meant = data.draw(st.sampled_from(names))
    message = str(UnknownNameError("name", meant + "z", names))
    assert any(f"Did you mean {candidate!r}?" in message for candidate in names)


def test_invalid_value_shows_value_unit_and_what_is_allowed() -> None:
    assert str(InvalidValueError("duration", -1.0, "above 0", "s")) == "duration is -1.0 s; allowed: above 0."
    assert str(InvalidValueError("seed", "a", "an integer")) == "seed is 'a'; allowed: an integer."


def test_wrong_shape_shows_both_shapes() -> None:
    error = ShapeError("action", [2, 4], "(..., 3)")
    assert error.shape == (2, 4)
    assert str(error) == "action has shape (2, 4); expected (..., 3)."


def test_joint_limit_shows_joint_value_and_range() -> None:
    error = JointLimitError("goal", 2, 0.1, (-0.3, 0.0), "m")
    assert str(error) == "goal: joint 2 is 0.1 m; allowed: -0.3 to 0 m."


def test_unreachable_point_shows_point_residual_and_reasons() -> None:
    error = UnreachableError([0.1, 0.0, 0.15], 0.25, ["first", "second"])
    assert error.position == (0.1, 0.0, 0.15)
    assert error.broken == ("first", "second")
    assert "(0.1, 0, 0.15) m in the world frame" in str(error)
    assert "misses it by 0.25 m; broken: first; second." in str(error)


def test_missing_field_shows_controller_missing_and_given_fields() -> None:
    error = MissingFieldError("impedance", ["contact_force"], ["joint_position"])
    assert str(error) == (
        "controller 'impedance' reads observation fields that this environment does not give: contact_force."
        " Fields given: joint_position."
    )


def test_missing_package_shows_the_command_that_installs_it() -> None:
    assert str(MissingPackageError("stable_baselines3", "agents")) == (
        "stable_baselines3 is not installed; install it with: pip install 'prp-gym[agents]'"
    )


@pytest.mark.parametrize("error", WITH_FACTS, ids=class_name)
def test_error_survives_the_transfer_between_processes(error: PRPError) -> None:
    back = pickle.loads(pickle.dumps(error))
    assert str(back) == str(error)
    assert repr(vars(back)) == repr(vars(error))


@pytest.mark.parametrize("error", WITHOUT_FACTS, ids=class_name)
def test_error_without_facts_survives_the_transfer_between_processes(error: PRPError) -> None:
    back = pickle.loads(pickle.dumps(error))
    assert (type(back), str(back)) == (type(error), str(error))


@pytest.mark.parametrize("error", EXAMPLES, ids=class_name)
def test_error_can_be_made_again_from_its_message(error: PRPError) -> None:
    again = type(error)(str(error))
    assert (type(again), str(again)) == (type(error), str(error))
    back = pickle.loads(pickle.dumps(again))
    assert (type(back), str(back)) == (type(error), str(error))


@pytest.mark.parametrize("error", WITH_FACTS, ids=class_name)
def test_error_made_again_from_itself_keeps_its_facts(error: Any) -> None:
    again = type(error)(error)
    assert (type(again), str(again)) == (type(error), str(error))
    assert repr(vars(again)) == repr(vars(error))


def test_constructor_without_its_facts_is_refused_as_any_other() -> None:
    arguments: list[Any] = ["duration", -1.0]
    with pytest.raises(TypeError, match="missing 1 required positional argument: 'allowed'"):
        InvalidValueError(*arguments)


def test_unknown_keyword_is_refused_in_pythons_words() -> None:
    error = UnknownKeywordError("the environment", "duratoin", ("duration", "scenario"))
    assert isinstance(error, TypeError)
    assert str(error) == (
        "the environment got an unexpected keyword argument 'duratoin'. Did you mean 'duration'?"
        " Valid: duration, scenario."
    )
