"""Texts in ASCII: legible replacements of all other characters."""

import unicodedata

_ASCII, _END_OF_NAMES = 0x80, 0x180  # first code points beyond ASCII and Latin Extended-A

_LETTERS = """
µ u  μ u  ² ^2  ³ ^3  ⁻ ^-  ¹ ^1  ° deg  ± +/-  ½ 1/2  ₑ _e
≤ <=  ≥ >=  ≠ !=  ≈ ~  → ->  ← <-  × x  √ sqrt  ∞ inf  ∫ integral  Σ sum  ∂ d  ∈ in
– -  — -  − -  … ...  ‖ ||  “ "  ” "  ‘ '  ’ '  • *  ✓ yes  ✗ no
─ -  ━ -  │ |  ┃ |  ╭ +  ╮ +  ╰ +  ╯ +  ┌ +  ┐ +  └ +  ┘ +  ├ +  ┤ +  ┬ +  ┴ +  ┼ +
"""
_REPLACED = {
    **dict(zip(_LETTERS.split()[::2], _LETTERS.split()[1::2], strict=True)),
    "·": " ",
    "\u00a0": " ",
    "\u0301": "",
    "\u0300": "",
    "\u0307": "_dot",
    "\u0308": "_ddot",
    "\u0302": "_hat",
    "\u0304": "_bar",
    "\u0303": "_tilde",
}
"""Characters with their replacements; those of the last lines combine with the letter before them."""


def legible(text: str) -> str:
    """A text in ASCII: `ẋ` is `x_dot`, `m²` is `m^2`, `γ` is `gamma`."""
    if text.isascii():
        return text
    return "".join(map(_letter, text))


def _letter(letter: str) -> str:
    """One character in ASCII."""
    if ord(letter) < _ASCII:
        return letter
    if letter in _REPLACED:
        return _REPLACED[letter]
    name = unicodedata.name(letter, "")
    if name.startswith("GREEK") and " WITH " not in name:
        word = name.rpartition(" ")[2].lower()
        return word.capitalize() if "CAPITAL" in name else word
    parts = unicodedata.normalize("NFKD", letter)
    if ord(letter) < _END_OF_NAMES:  # a letter of a name, whose accents are no derivatives
        parts = parts[0]
    return "?" if parts == letter else "".join(map(_letter, parts))
