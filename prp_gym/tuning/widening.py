"""Ranges of the search that grow where the best candidate lies at their edge."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from prp_gym.tuning.search_space import Parameter
from prp_gym.tuning.trial import Trial

EDGE = 0.05
"""Share of a range, in the logarithm of the factor, that counts as its edge."""

MOST_WIDENINGS = 3
"""How often one end of a range may grow, each time by half of the declared range in the logarithm."""

NO_LIMIT = "edge of the searched range, which is no limit"


@dataclass(frozen=True)
class Ranges:
    """The ranges of a search after some trials, and the edges at which its best candidate lies.

    Attributes:
        parameters: parameters with their ranges as they are now.
        edges: reasons for which a factor of the best candidate lies at an edge, by parameter and end, such as
            `bandwidth, high`: that of the declared limit, or `NO_LIMIT`.
    """

    parameters: tuple[Parameter, ...]
    edges: Mapping[str, str]

    @property
    def is_open(self) -> bool:
        """Whether the best candidate lies at an edge that is no limit."""
        return NO_LIMIT in self.edges.values()


def ranges_after(declared: Sequence[Parameter], trials: Sequence[Trial]) -> Ranges:
    """The ranges after some trials, which depend on these alone.

    Whenever a candidate is the best so far and one of its factors is within `EDGE` of an end of the range,
    that end moves out, unless it is a declared limit or has moved `MOST_WIDENINGS` times. The best candidate
    no longer counts as being at an edge that has moved once twice as many trials as there are parameters have
    followed it and none of them was better.

    Args:
        declared: parameters with their declared ranges.
        trials: finished trials in their order.
    """
    now, widened = tuple(declared), dict.fromkeys(_ends(declared), 0)
    edges: dict[str, str] = {}
    moved: set[str] = set()
    best, since = -math.inf, 0
    for trial in trials:
        since += 1
        if trial.stopped or trial.score <= best:
            continue
        best, since = trial.score, 0
        edges = {end: item.limits[high] or NO_LIMIT for item, high, end in _reached(now, trial.factors)}
        moved = {end for end, reason in edges.items() if reason == NO_LIMIT and widened[end] < MOST_WIDENINGS}
        for end in moved:
            widened[end] += 1
        now = tuple(_grown(item, widened) for item in declared)
    if since >= 2 * len(declared):
        edges = {end: reason for end, reason in edges.items() if end not in moved}
    return Ranges(now, edges)


def widest(item: Parameter) -> tuple[float, float]:
    """The smallest and the largest factor that a search may ever try."""
    most = dict.fromkeys(_ends([item]), MOST_WIDENINGS)
    grown = _grown(item, most)
    return grown.low, grown.high


def _ends(parameters: Sequence[Parameter]) -> Iterator[str]:
    for item in parameters:
        yield from (_end(item, high=False), _end(item, high=True))


def _end(item: Parameter, high: bool) -> str:
    return f"{item.name}, {'high' if high else 'low'}"


def _reached(
    parameters: Sequence[Parameter], factors: Mapping[str, float]
) -> Iterator[tuple[Parameter, bool, str]]:
    """The ends of ranges at which factors lie."""
    for item in parameters:
        share = math.log(factors[item.name] / item.low) / math.log(item.high / item.low)
        if share < EDGE:
            yield item, False, _end(item, high=False)
        if share > 1.0 - EDGE:
            yield item, True, _end(item, high=True)


def _grown(item: Parameter, widened: Mapping[str, int]) -> Parameter:
    """A declared parameter with its range as it is after so many widenings of its ends."""
    step = math.sqrt(item.high / item.low)
    low = item.low / step ** widened[_end(item, high=False)]
    return replace(item, low=low, high=item.high * step ** widened[_end(item, high=True)])
