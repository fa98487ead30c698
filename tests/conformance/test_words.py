"""The project's words: none of its former dialect, unique class names, docs that can be read alone."""

import ast
import re
import subprocess
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("prp_gym", "envs", "baselines", "agents")
SUFFIXES = {".py", ".md", ".toml", ".yml", ".yaml", ""}
THIS_FILE = Path(__file__).resolve().relative_to(ROOT).as_posix()
GENERATED_DATA = ("agents/trained/", "baselines/searches/")  # cards with checksums, results of runs

GAP = r"[\s#\"'`*]+"
"""Between the words of a phrase; it may hold a line break in a comment or between two literals."""


class Word(NamedTuple):
    """A word of the dialect.

    Attributes:
        dialect: regular expression of what must not be written.
        instead: what is written instead.
        legitimate: regular expressions of phrases in which the word is the field's own, or plain English.
    """

    dialect: str
    instead: str
    legitimate: tuple[str, ...] = ()

    def hits(self, text: str) -> Iterator[int]:
        """Positions of the dialect in a text whose identifiers were split into words."""
        spared = [f"(?:{phrase})" for phrase in self.legitimate]
        pattern = "|".join([*spared, f"(?P<hit>{self.dialect})"]).replace(" ", GAP)
        for match in re.finditer(rf"\b(?:{pattern})\b", text, flags=re.IGNORECASE):
            if match.group("hit") is not None:
                yield match.start("hit")


WORDS = (
    Word(
        "laws?",
        "controller; control law for the formula",
        (
            "(control|adaptation|update|power|scaling|conservation|algebraic) laws?",
            "(hooke|coulomb|newton|faraday|moore)'s laws?",
        ),
    ),
    Word("(plays?|played|playing|player)", "run or evaluate", ("plays? (a|no|the) role",)),
    Word(
        "pairs?",
        "job, or what the two are",
        (
            "pairs? of",
            "object pairs hook",
            "(contact|geom|collision) pairs?",
            "pair name",
            r"pair (sol|geom|friction|margin|dim)\w*",
        ),
    ),
    Word(
        "places?",
        "condition, contact point or reset: what it is",
        ("(in|take|takes|taken|taking|took) (the |its |their |one )?place", "decimal places?", "one place"),
    ),
    Word("steer(s|ed|ing)?", "command, set or scale"),
    Word("whoever", "the user, the caller or the agent: who it is"),
    Word("truths?", "ground truth", (r"ground[-\s]truths?", "truth values?")),
    Word("what (is|was) true( now)?", "ground truth"),
    Word("judge(s|d)? (on|by|what)", "computed from"),
    Word("remember(s|ed|ing)?", "stateful; keeps in its state"),
    Word("late torques?", "one-step actuation delay"),
    Word("wrong (link )?mass(es)?", "link-mass errors"),
    Word("imperfect", "noise and bias"),
    Word("no torque( at all)?|does nothing|worth to", "zero-torque baseline"),
    Word("over the actuator limits?", "normalised by the actuator limits"),
    Word("duel(s|led)?", "pairwise comparison"),
    Word("gauge[sd]?", "task error"),
    Word("forfeit(s|ed)?", "zero reward"),
    Word("calm", "within limits"),
    Word("asked", "target impedance; requested", ("asked (for|to|again)",)),
    Word("slip(s|ped)?", "sliding variable", ("slip (speed|velocity)", r"(stick|tangential)[-\s]slip")),
    Word("pace[sd]?", "rate scaling"),
    Word("files without code|without pickle", "pickle-free files"),
    Word("pictures?", "frame, image or figure: what it is"),
    Word(
        "marks?",
        "overlay",
        (
            r"pytest\.mark",
            r"marks(?==)",
            "(question|quotation|check|byte order) marks?",
            "(start|end|problem) mark",
        ),
    ),
    Word("(at )?(the|its|a period's) begin|begin of", "start of"),
    Word(
        "(actions?|steps?|times|periods?|samples?|frames?|iterations?|transitions?|renewals?) a second",
        "control frequency; per second",
    ),
    Word("(pairs?|jobs?|runs?) at once", "parallel workers"),
    Word("rendering (task|env|tasks|envs)", "impedance rendering", ("(impedance|frame) rendering [a-z]+",)),
)

DANGLING = re.compile(r"(of|by|for|from|with|at|to|in|on|as|which|whose|who) ", re.IGNORECASE)
"""How a description begins that needs the name before it."""

FORMER_NAMES: dict[str, tuple[str, ...]] = {
    "CHANGELOG.md": ("make pictures", "`truth`"),
    "envs/loop_environment.py": ("def truth", "env.truth"),
    "tests/envs/test_former_names.py": ("test_truth", "env.truth"),
    "prp_gym/files/json_text.py": ("object_pairs_hook",),
}
"""Names that stay for a release with a `DeprecationWarning`, by the file that may still write them."""


def tracked() -> list[str]:
    """Texts of the repository that people read, relative to its root."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
    return [
        name
        for name in listed.stdout.splitlines()
        if Path(name).suffix in SUFFIXES
        and (ROOT / name).is_file()
        and not (ROOT / name).is_symlink()
        and not name.startswith(GENERATED_DATA)
        and name not in (THIS_FILE, "LICENSE")
    ]


def as_words(text: str) -> str:
    """Identifiers as the words that they consist of, on the lines where they were."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|_", " ", text)


def hits(name: str) -> list[str]:
    """The dialect in the name and in the text of a file, as `file:line: found; instead`."""
    content = (ROOT / name).read_text(encoding="utf-8")
    for former in FORMER_NAMES.get(name, ()):
        content = content.replace(former, "")
    found = []
    for where, text in ((0, as_words(name.replace("/", " / "))), (1, as_words(content))):
        for word in WORDS:
            for start in word.hits(text):
                line = where and text.count("\n", 0, start) + 1
                excerpt = " ".join(text[max(0, start - 25) : start + 35].split())
                found.append((line, f"{name}:{line}: ...{excerpt}...; write: {word.instead}"))
    return [text for _, text in sorted(found)]


def declared_classes() -> dict[str, list[str]]:
    """Where the classes of the package are declared, by name."""
    found = defaultdict(list)
    for name in tracked():
        if name.endswith(".py") and name.startswith(PACKAGES):
            for node in ast.parse((ROOT / name).read_text(encoding="utf-8")).body:
                if isinstance(node, ast.ClassDef):
                    found[node.name].append(f"{name}:{node.lineno}")
    return found


def attribute_phrases(name: str) -> Iterator[tuple[str, str, str]]:
    """Class, attribute and description of each entry of a file's `Attributes:` sections."""
    for node in ast.walk(ast.parse((ROOT / name).read_text(encoding="utf-8"))):
        if isinstance(node, ast.ClassDef):
            _, _, section = (ast.get_docstring(node) or "").partition("Attributes:\n")
            for line in section.split("\n\n")[0].splitlines():
                entry = re.fullmatch(r" {4}(\w+): (.+)", line)
                if entry:
                    yield node.name, entry[1], entry[2]


def test_no_word_of_the_former_dialect_is_left() -> None:
    assert [hit for name in tracked() for hit in hits(name)] == []


def test_class_names_are_unique() -> None:
    assert {name: where for name, where in declared_classes().items() if len(where) > 1} == {}


def test_descriptions_of_attributes_can_be_read_alone() -> None:
    modules = [name for name in tracked() if name.endswith(".py") and name.startswith(PACKAGES)]
    phrases = [(name, *entry) for name in modules for entry in attribute_phrases(name)]
    assert len(phrases) > 500
    assert [entry for entry in phrases if DANGLING.match(entry[3])] == []


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("the law that is evaluated", 1),
        ("the control law, Faraday's law and Coulomb's\n    # law", 0),
        ("joint_torques = law_of(Law)", 2),
        ('"whose control"\n    " law is linear"', 0),
        ("play the display back in place", 1),
        ("PlayPairs", 2),
        ("ground truth, not the truth", 1),
        ("workspace, replace, benchmark, pairwise, paired, spaced", 0),
        ("@pytest.mark.slow draws marks", 1),
        ("a slip speed, a slip", 1),
        ("500 steps\na second", 1),
    ],
)
def test_the_list_finds_the_dialect_and_spares_the_rest(text: str, found: int) -> None:
    assert sum(len(list(word.hits(as_words(text)))) for word in WORDS) == found
