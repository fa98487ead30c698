"""The journal of a search: what its lines may say, checked before Optuna reads them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from json import JSONDecodeError, JSONDecoder
from pathlib import Path
from typing import Any

from prp_gym.errors import DataFileError, DataTextError
from prp_gym.files.checksum import KEY, checksum
from prp_gym.files.file_reader import RECORD_SIZE, FileReader
from prp_gym.files.json_text import parse_json
from prp_gym.files.typed_reader import TypedReader
from prp_gym.tuning.candidates import Space
from prp_gym.tuning.widening import widest

JOURNAL = "study.log"
STUDY_NAME, KEY_OF_SEARCH = "tuning", "key"
_REMEDY = "It is left as it is; to search anew, move it away or choose another folder with --output"
_STUDY, _ATTRIBUTE, _TRIAL = 0, 2, 4  # Optuna's codes of the operations that a search writes
SLOPES = "slopes"
_ATTRIBUTES = frozenset(("steps", "seconds", "by_scenario", "stopped"))
_COMPLETE = 1


@dataclass(frozen=True)
class StudyLine:
    """A line that begins the study, or goes on with it.

    Attributes:
        study_name: name of the study.
        directions: Optuna's codes of the directions of optimisation.
    """

    study_name: str
    directions: tuple[int, ...]


@dataclass(frozen=True)
class AttributeLine:
    """A line with the key of the search.

    Attributes:
        study_id: number of the study in the journal.
        user_attr: mapping that holds the key.
    """

    study_id: int
    user_attr: Mapping[str, Mapping[str, Any]]


@dataclass(frozen=True)
class TrialLine:
    """A line with a finished trial.

    Attributes:
        study_id: number of the study in the journal.
        state: Optuna's code of the trial's state.
        value: score of the trial.
        params: factors by the names of the parameters.
        distributions: distributions of the factors, as Optuna's JSON.
        user_attrs: steps, seconds and scores of the trial, whether it was stopped, and the checksum.
    """

    study_id: int
    state: int
    value: float
    params: Mapping[str, float]
    distributions: Mapping[str, str]
    user_attrs: Mapping[str, Any]


def trial_checksum(
    score: float, params: Mapping[str, float], distributions: Mapping[str, str], attributes: Mapping[str, Any]
) -> str:
    """The checksum of a trial, which stands among its attributes.

    Args:
        score: score of the trial.
        params: factors by the names of the parameters.
        distributions: distributions of the factors, as Optuna's JSON.
        attributes: steps, seconds and scores of the trial, and whether it was stopped.
    """
    return checksum([score, dict(params), dict(distributions), dict(attributes)])


def read_key(path: Path, space: Space) -> Mapping[str, Any]:
    """The key of a search; refuse a journal that a search in this space cannot have written.

    The file is not changed. What stands behind the last complete line must be the beginning of a line, as a
    killed run leaves it.

    Args:
        path: path of the journal.
        space: space that is searched.

    Returns:
        everything that the trials depend on besides their factors; empty for a journal without it.

    Raises:
        DataFileError: a journal that is damaged or altered; it says in which line.
    """
    key: Mapping[str, Any] = {}
    *lines, rest = FileReader(RECORD_SIZE).read_text(path).split("\n")
    for number, line in enumerate(lines, 1):
        try:
            key = _check_line(path, parse_json(line), space) or key
        except (DataTextError, DataFileError, ValueError) as error:
            what = getattr(error, "what", str(error))
            raise DataFileError(path, f"line {number} is damaged: {what}", _REMEDY) from error
    if rest and not _is_beginning(rest):
        raise DataFileError(path, f"line {len(lines) + 1}, the last one, is damaged", _REMEDY)
    return key


def _is_beginning(text: str) -> bool:
    """Whether a text is the beginning of a line, or a line without its end."""
    try:
        parse_json(text)
    except DataTextError:
        try:
            JSONDecoder().raw_decode(text)
        except (JSONDecodeError, RecursionError):
            return text.startswith("{")
        return False
    return True


def _check_line(path: Path, line: Any, space: Space) -> Mapping[str, Any]:
    """The key of the search, if the line holds it; empty for other lines.

    Raises:
        DataFileError: a part of another type.
        ValueError: a part that no search writes.
    """
    key: Mapping[str, Any] = {}
    if not isinstance(line, dict) or line.get("study_id", 0) != 0:
        raise ValueError("it is not of this search")
    code = line.get("op_code")
    if code == _STUDY:
        study = _read(path, StudyLine, line)
        if study != StudyLine(STUDY_NAME, (2,)):
            raise ValueError(f"it is not of the study {STUDY_NAME!r}")
    elif code == _ATTRIBUTE:
        attributes = _read(path, AttributeLine, line).user_attr
        if set(attributes) != {KEY_OF_SEARCH}:
            raise ValueError(f"the study has other attributes than {KEY_OF_SEARCH!r}")
        key = attributes[KEY_OF_SEARCH]
    elif code == _TRIAL:
        _check_trial(_read(path, TrialLine, line), space)
    else:
        raise ValueError("its op_code is none that a search writes")
    return key


def _check_trial(trial: TrialLine, space: Space) -> None:
    attributes = dict(trial.user_attrs)
    digest = attributes.pop(KEY, None)
    _check_slopes(attributes.get(SLOPES, {}), trial)
    if set(attributes) - {SLOPES} != _ATTRIBUTES or type(attributes["steps"]) is not int:
        raise ValueError(f"its user_attrs are not {', '.join(sorted(_ATTRIBUTES))}")
    if type(attributes["seconds"]) not in (int, float) or attributes["steps"] < 0:
        raise ValueError("its steps or seconds are no numbers from 0 on")
    scores = attributes["by_scenario"]
    if not isinstance(scores, list) or not scores or not all(type(score) is float for score in scores):
        raise ValueError("its by_scenario is no list of scores")
    if type(attributes["stopped"]) is not bool:
        raise ValueError("its stopped is neither true nor false")
    found = trial_checksum(trial.value, trial.params, trial.distributions, attributes)
    if digest != found:
        raise ValueError("its checksum does not fit the rest")
    bounds = {item.name: widest(item) for item in space.parameters}
    if trial.state != _COMPLETE or set(trial.params) != set(bounds):
        raise ValueError("its parameters are not those of this search, or it is not complete")
    for name, (low, high) in bounds.items():
        if not low <= trial.params[name] <= high:
            raise ValueError(f"its parameter {name!r} is out of range")


def _check_slopes(slopes: Any, trial: TrialLine) -> None:
    names = set(trial.params)
    if not isinstance(slopes, dict) or (slopes and set(slopes) != names):
        raise ValueError(f"its {SLOPES} are not those of its parameters")
    if not all(type(slope) is float and math.isfinite(slope) for slope in slopes.values()):
        raise ValueError(f"its {SLOPES} are no finite numbers")


def _read(path: Path, kind: type[Any], line: dict[str, Any]) -> Any:
    """The parts of a line that a search depends on."""
    names = {field.name for field in fields(kind)}
    return TypedReader(path).read(kind, {name: line[name] for name in line if name in names}, "")
