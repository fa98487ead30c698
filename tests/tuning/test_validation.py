"""Which candidate a search ends with: the best on fresh episodes, or its start."""

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from prp_gym.errors import DataFileError
from prp_gym.tuning import Candidates, StoredScores, Trial, Tuned, choose
from prp_gym.tuning.objective import EpisodeRows
from prp_gym.tuning.stored_scores import VALIDATION
from prp_gym.tuning.validation import paired_gain, rounded_settings
from prp_gym.tuning.widening import Ranges
from tests.tuning.test_journal import PlainSpace

SELECTION, FINAL = 501_000_000, 500_000_000


class Fresh:
    """Two scenarios of two episodes; the score of a candidate depends on its first factor, as told."""

    def __init__(self, score_of: Mapping[float, float], seen: list[float]) -> None:
        self.score_of, self.seen, self.episodes = score_of, seen, 0

    def episode_scores(
        self, settings_of: Sequence[Callable[[Candidates], Mapping[str, Any]]]
    ) -> list[EpisodeRows]:
        return [[[score, score], [score, score]] for score in map(self._score, settings_of)]

    def _score(self, settings_of: Callable[[Candidates], Mapping[str, Any]]) -> float:
        factor = settings_of(Candidates(PlainSpace(), lambda values: None))["first"]  # type: ignore[arg-type, return-value]
        self.seen.append(factor)
        return self.score_of[factor]


class Kept:
    """Scores that are not kept."""

    def find(
        self, names: Sequence[str], compute: Callable[[Sequence[str]], Sequence[EpisodeRows]]
    ) -> list[EpisodeRows]:
        return list(compute(names))


def tuned(scores: Sequence[float]) -> Tuned:
    """Candidates with the first factors 1, 2, 3, ... and these training scores."""
    trials = [
        Trial({"first": 1.0 + number, "second": 1.0}, score, 1, 0.0, (score,))
        for number, score in enumerate(scores)
    ]
    return Tuned(trials, Ranges((), {}))


def run(
    search: Tuned, selection: Mapping[float, float], final: Mapping[float, float], scores: Any = None
) -> tuple[Any, list[float], list[float]]:
    seen: dict[int, list[float]] = {SELECTION: [], FINAL: []}
    score_of = {SELECTION: selection, FINAL: final}

    def make(seed: int, episodes: int) -> Any:
        made = Fresh(score_of[seed], seen[seed])
        made.episodes = episodes
        return made

    return choose(search, make, Kept() if scores is None else scores), seen[SELECTION], seen[FINAL]


def test_candidate_that_is_best_in_training_but_worse_on_fresh_episodes_is_not_chosen() -> None:
    found, first, last = run(
        tuned([0.5, 0.9, 0.7, 0.6, 0.65]),
        {2.0: 0.4, 3.0: 0.7, 4.0: 0.6, 5.0: 0.65},
        {1.0: 0.5, 3.0: 0.6, 4.0: 0.66, 5.0: 0.55},
    )
    assert first == [2.0, 3.0, 5.0, 4.0]  # by training score, without the start
    assert sorted(last) == [1.0, 3.0, 4.0, 5.0]  # the best three of these, and the start
    assert found.trial.factors["first"] == 4.0
    checked = found.validation
    assert (checked.score, checked.score_of_start, checked.kept_start) == (0.66, 0.5, False)
    assert (checked.episodes, checked.selection_episodes) == (100, 20)
    assert (checked.seed, checked.selection_seed) == (FINAL, SELECTION)
    assert (checked.selection, checked.finalists) == ((0.4, 0.7, 0.65, 0.6), (0.6, 0.55, 0.66))


@pytest.mark.parametrize("best", [0.49, 0.5])
def test_start_is_kept_unless_a_candidate_is_better_on_fresh_episodes(best: float) -> None:
    found, _, _ = run(tuned([0.5, 0.9]), {2.0: 0.8}, {1.0: 0.5, 2.0: best})
    assert found.trial.factors["first"] == 1.0
    assert (found.validation.score, found.validation.kept_start) == (0.5, True)


@pytest.mark.parametrize(("gain", "kept"), [(0.019, True), (0.021, False)])
def test_gain_within_two_standard_errors_keeps_the_start(gain: float, kept: bool) -> None:
    class Spread(Fresh):
        """Candidates are better by `gain` in the mean, with a standard deviation of 0.1 over 50 episodes."""

        def episode_scores(
            self, settings_of: Sequence[Callable[[Candidates], Mapping[str, Any]]]
        ) -> list[EpisodeRows]:
            swing = 0.1 * np.sqrt(49 / 50) * np.resize([1.0, -1.0], 50)
            means = [self._score(item) for item in settings_of]
            return [[[0.5] * 50 if mean == 0.5 else (mean + swing).tolist()] * 2 for mean in means]

    # two scenarios: 0.1/sqrt(50)/sqrt(2) = 0.01
    final = {1.0: 0.5, 2.0: 0.5 + gain}
    found = choose(tuned([0.5, 0.9]), lambda seed, episodes: with_episodes(Spread(final, [])), Kept())
    assert found.validation.kept_start == kept
    assert found.validation.gain == pytest.approx(gain)
    assert found.validation.gain_error == pytest.approx(0.01)
    assert found.validation.score == pytest.approx(0.5 if kept else 0.5 + gain)


def with_episodes(fresh: Fresh) -> Any:
    fresh.episodes = 100
    return fresh


def test_standard_error_of_the_gain_is_that_of_paired_episodes() -> None:
    rng = np.random.default_rng(8)
    hard, noise = rng.normal(0.5, 0.3, (400, 2, 50)), rng.normal(0.0, 0.02, (2, 400, 2, 50))
    found = np.array(
        [paired_gain(own.tolist(), other.tolist()) for own, other in zip(*(hard + noise), strict=True)]
    )
    gains, errors = found.T
    # the spread of hard and easy episodes cancels; 400 draws tell a standard deviation within 4 %
    np.testing.assert_allclose(gains.std(), 0.02 * np.sqrt(2.0 / 100.0), rtol=0.15)
    np.testing.assert_allclose(errors.mean(), 0.02 * np.sqrt(2.0 / 100.0), rtol=0.02)


def test_search_of_the_start_alone_keeps_it() -> None:
    found, first, last = run(tuned([0.5]), {}, {1.0: 0.4})
    assert (first, last) == ([], [1.0])
    assert found.validation.kept_start


def test_ten_candidates_are_validated_and_those_that_were_stopped_are_not() -> None:
    search = tuned([0.5, *np.linspace(0.6, 0.8, 15)])
    stopped = Trial({"first": 99.0, "second": 1.0}, 0.95, 1, 0.0, (0.9,), stopped=True)
    search = Tuned([*search.trials, stopped], search.ranges)
    even = {float(number): 0.5 for number in range(1, 17)}
    _, first, last = run(search, even, even)
    assert first == [float(number) for number in range(16, 6, -1)]
    assert len(last) == 4


def test_validation_that_was_killed_goes_on_to_the_same_end(tmp_path: Path) -> None:
    search = tuned([0.5, 0.9, 0.8])
    selection, final = {2.0: 0.7, 3.0: 0.6}, {1.0: 0.4, 2.0: 0.5, 3.0: 0.6}
    expected, _, _ = run(search, selection, final)
    for _ in range(2):  # killed in the second stage, before its last score
        with pytest.raises(KeyError):
            run(search, selection, {2.0: 0.5, 3.0: 0.6}, StoredScores(tmp_path, {"a": 1}))
    found, first, last = run(search, selection, final, StoredScores(tmp_path, {"a": 1}))
    assert (first, last) == ([], [2.0, 3.0, 1.0])
    again, first, last = run(search, {}, {}, StoredScores(tmp_path, {"a": 1}))  # all of them are kept
    assert (first, last, again.validation) == ([], [], expected.validation)
    assert (found.trial, found.validation) == (expected.trial, expected.validation)
    _, first, last = run(search, selection, final, StoredScores(tmp_path, {"a": 2}))  # of another search
    assert (len(first), len(last)) == (2, 3)


@pytest.mark.parametrize("change", ['{"scores": {}}', "[]", "{", ""])
def test_damaged_scores_are_refused_and_left_as_they_are(tmp_path: Path, change: str) -> None:
    (tmp_path / VALIDATION).write_text(change, encoding="utf-8")
    with pytest.raises(DataFileError, match=VALIDATION):
        StoredScores(tmp_path, {})
    assert (tmp_path / VALIDATION).read_text(encoding="utf-8") == change


def test_altered_score_is_refused(tmp_path: Path) -> None:
    assert StoredScores(tmp_path, {}).find(["one"], lambda names: [[[0.25]]]) == [[[0.25]]]
    content = json.loads((tmp_path / VALIDATION).read_text(encoding="utf-8"))
    content["scores"]["one"] = [[0.75]]
    (tmp_path / VALIDATION).write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(DataFileError, match="damaged or altered"):
        StoredScores(tmp_path, {})


class Given(PlainSpace):
    """A space whose settings are the same whatever the factors."""

    def settings(self, factors: Any) -> dict[str, Any]:
        return {
            "one": 1.23456,
            "many": np.array([0.000123456, 0.0, 98765.4]),
            "word": "start",
            "few": [2 / 3],
        }


def test_settings_are_rounded_to_four_significant_digits() -> None:
    found = rounded_settings(Candidates(Given(), lambda values: None), {})  # type: ignore[arg-type, return-value]
    assert (found["one"], found["word"], found["few"]) == (1.235, "start", [0.6667])
    assert found["many"].tolist() == [0.0001235, 0.0, 98770.0]
