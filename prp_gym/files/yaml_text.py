"""`parse_yaml`: plain values from YAML, made from its events, so that nothing else can come of it."""

from typing import Any

from prp_gym.errors import DataTextError, shortened
from prp_gym.extras import require
from prp_gym.files.limits import DEPTH, INTEGER_DIGITS

_PLAIN = tuple(f"tag:yaml.org,2002:{name}" for name in ("null", "bool", "int", "float", "str"))


def parse_yaml(text: str) -> Any:
    """The value that a text in YAML stands for; None for a text without a value.

    Args:
        text: text of any origin.

    Raises:
        DataTextError: text that is not one document of YAML, an anchor, alias or tag, a key that is not text
            or is given twice, a date, a whole number of more than `INTEGER_DIGITS` digits, or more than
            `DEPTH` levels.
        MissingPackageError: PyYAML is not installed.
    """
    yaml = require("yaml")
    try:
        loader = yaml.SafeLoader(text)
        try:
            return _read(yaml, loader)
        finally:
            loader.dispose()
    except yaml.YAMLError as fault:
        line = getattr(getattr(fault, "problem_mark", None), "line", None)
        where = "" if line is None else f" in line {line + 1}"
        what = str(getattr(fault, "problem", None) or getattr(fault, "reason", None) or "syntax error")
        raise DataTextError("YAML", f"{what}{where}") from None


def _read(yaml: Any, loader: Any) -> Any:
    """The value of the only document."""
    tree = _Tree()
    documents = 0
    while loader.check_event():
        event = loader.get_event()
        documents += isinstance(event, yaml.DocumentStartEvent)
        if documents > 1:
            raise DataTextError("YAML", "it has more than one document")
        _refuse_references(yaml, event)
        if isinstance(event, yaml.MappingStartEvent):
            tree.enter({})
        elif isinstance(event, yaml.SequenceStartEvent):
            tree.enter([])
        elif isinstance(event, yaml.CollectionEndEvent):
            tree.leave()
        elif isinstance(event, yaml.ScalarEvent):
            tree.add(_scalar(yaml, loader, event))
    return tree.value


def _refuse_references(yaml: Any, event: Any) -> None:
    line = event.start_mark.line + 1
    if isinstance(event, yaml.AliasEvent):
        raise DataTextError(
            "YAML", f"line {line} has the alias {shortened('*' + event.anchor)}; write it out"
        )
    if getattr(event, "anchor", None) is not None:
        raise DataTextError("YAML", f"line {line} has the anchor {shortened('&' + event.anchor)}; remove it")
    if getattr(event, "tag", None) is not None:
        raise DataTextError("YAML", f"line {line} has the tag {shortened(event.tag)}; remove it")


def _scalar(yaml: Any, loader: Any, event: Any) -> Any:
    """The text, number, truth value or null of an event."""
    tag = loader.resolve(yaml.ScalarNode, event.value, event.implicit)
    where = f"{shortened(event.value)} in line {event.start_mark.line + 1}"
    if tag not in _PLAIN:
        kind = tag.rpartition(":")[2]
        raise DataTextError("YAML", f"{where} is read as a {kind}; a text like this needs quotation marks")
    if tag.endswith(":int") and len(event.value) > INTEGER_DIGITS:
        raise DataTextError("YAML", f"{where} has more than {INTEGER_DIGITS} digits")
    try:
        return loader.construct_object(yaml.ScalarNode(tag, event.value, event.start_mark, event.end_mark))
    except (ValueError, OverflowError):
        raise DataTextError("YAML", f"{where} is not a number") from None


class _Tree:
    """The value that grows with the events of a document.

    Attributes:
        value: Value of the document so far.
    """

    def __init__(self) -> None:
        self.value: Any = None
        self._open: list[
            tuple[Any, list[str]]
        ] = []  # lists and mappings, with the key that waits for a value

    def enter(self, collection: Any) -> None:
        """Begin a list or mapping."""
        if len(self._open) == DEPTH:
            raise DataTextError("YAML", f"it has more than {DEPTH} levels")
        self.add(collection)
        self._open.append((collection, []))

    def leave(self) -> None:
        """End the innermost list or mapping."""
        self._open.pop()

    def add(self, value: Any) -> None:
        """Add a value, or a key where a mapping waits for one."""
        if not self._open:
            self.value = value
            return
        collection, keys = self._open[-1]
        if isinstance(collection, list):
            collection.append(value)
        elif keys:
            collection[keys.pop()] = value
        else:
            self._add_key(collection, keys, value)

    def _add_key(self, collection: dict[str, Any], keys: list[str], key: Any) -> None:
        if not isinstance(key, str):
            raise DataTextError("YAML", f"key {shortened(key)} is not text; put it in quotation marks")
        if key in collection:
            raise DataTextError("YAML", f"key {shortened(key)} is given twice")
        keys.append(key)
