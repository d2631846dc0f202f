"""Equations of docs/theory.md as MathML, which browsers draw without a script or a network.

The page writes them as plain text, so that it reads well as it stands: an indented line that may end with the
number of the equation, "    g_q = Σ_i J_iᵀ g_i      (5)".
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from html import escape

_EQUATION = re.compile(r"^    (?P<formula>\S.*?)(?:\s+\((?P<number>\d+[a-z]?)\))?$")
_ACCENTS = {"\u0302": "^", "\u0303": "~", "\u0304": "¯", "\u0307": "˙"}
_LOWERED = dict(zip("₀₁₂₃₄₅₆₇₈₉ₐₑᵢⱼₖₙ", "0123456789aeijkn", strict=True))
_RAISED = dict(zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻ⁿᵀ*'′", "0123456789+−nT*′′", strict=True))
_FUNCTIONS = {"clamp", "cos", "det", "exp", "ln", "max", "min", "sin", "tan", "tr"}
#: Letters side by side that are no word but a product or a differential.
_PRODUCTS = {"dt", "dw", "dx", "EA", "kGA"}
_OPENING, _CLOSING = "([{⟨", ")]}⟩"
_TIGHT = "|/"
_TOKEN = re.compile(
    r"(?P<matrix>\[[^][]*;[^][]*\])|(?P<gap>  +)|(?P<space> )"
    r"|(?P<text>[a-z]-[a-z]{3,}|[a-z]{2,})"
    r"|(?P<number>\d+(?:\.\d+)?)"
    r"|(?P<below>_\{[^}]*\}|_[A-Za-zα-ωΑ-Ω0-9]+|[₀-₉ₐₑᵢⱼₖₙ]+)"
    r"|(?P<above>\^½|(?:[⁰¹²³⁴-⁹⁺⁻ⁿᵀ'′]|(?<=[^\s(])\*)+)"
    r"|(?P<root>√)|(?P<half>½)|(?P<sum>Σ)"
    r"|(?P<letter>[^\W\d_][\u0300-\u036f]?)"
    r"|(?P<sign>.)"
)


def with_mathml(markdown: str) -> str:
    """The page with a block of raw HTML in place of each equation."""
    lines = [_block(line) if _EQUATION.match(line) else line for line in markdown.splitlines()]
    return "\n".join(lines) + "\n"


def _block(line: str) -> str:
    found = _EQUATION.match(line)
    assert found is not None
    number = found["number"]
    label = f'<a class="eqno" href="#eq-{number}">({number})</a>' if number else ""
    place = f' id="eq-{number}"' if number else ""
    return f'\n```{{raw}} html\n<div class="equation"{place}>{mathml(found["formula"])}{label}</div>\n```\n'


def mathml(formula: str) -> str:
    """A formula in the notation of docs/theory.md as an element <math>."""
    return f'<math display="block">{_row(unicodedata.normalize("NFD", formula))}</math>'


def _row(formula: str) -> str:
    """Its elements one after another, indices and exponents put on what they belong to."""
    elements: list[_Element] = []
    for kind, text in _tokens(formula):
        if kind in ("below", "above"):
            elements[-1].put(kind, _script(text))
        else:
            elements.append(_Element(kind, text, after_operator=_ends_open(elements)))
    return "".join(_joined(elements))


def _tokens(formula: str) -> Iterator[tuple[str, str]]:
    """(kind, text); words that are products of letters come as letters."""
    place = 0
    while place < len(formula):
        product = next((p for p in _PRODUCTS if formula.startswith(p, place)), None)
        if product is not None and not formula[place + len(product) :][:1].isalpha():
            yield from (("letter", letter) for letter in product)
            place += len(product)
            continue
        found = _TOKEN.match(formula, place)
        assert found is not None and found.lastgroup is not None
        kind = found.lastgroup
        yield ("function" if kind == "text" and found[0] in _FUNCTIONS else kind), found[0]
        place = found.end()


class _Element:
    """One symbol, with what is written below and above of it."""

    def __init__(self, kind: str, text: str, after_operator: bool) -> None:
        self.kind, self.text = kind, text
        self._after_operator = after_operator
        self._scripts: dict[str, str] = {}

    def put(self, kind: str, script: str) -> None:
        """Adds an index or an exponent."""
        self._scripts[kind] = script

    def __str__(self) -> str:
        below, above = self._scripts.get("below"), self._scripts.get("above")
        base = _base(self.kind, self.text, self._after_operator)
        if below and above:
            return f"<msubsup>{base}{below}{above}</msubsup>"
        if below:
            tag = "munder" if self.kind == "sum" else "msub"
            return f"<{tag}>{base}{below}</{tag}>"
        return f"<msup>{base}{above}</msup>" if above else base

    @property
    def is_operand(self) -> bool:
        """Whether a space after it is a product, which shows as a thin space."""
        return self.kind not in ("gap", "space", "sign") or self.text in (*_CLOSING, "|", "∞")


def _ends_open(elements: list[_Element]) -> bool:
    """Whether a sign that comes next has nothing on its left."""
    seen = [element for element in elements if element.kind != "space"]
    return not seen or seen[-1].kind == "gap" or (seen[-1].kind == "sign" and not seen[-1].is_operand)


def _joined(elements: list[_Element]) -> Iterator[str]:
    """Elements as text; roots take the operand that follows, spaces stay where they separate operands."""
    k = 0
    while k < len(elements):
        element = elements[k]
        if element.kind == "root":
            last = k + 3 if elements[k + 1].kind == "function" else k + 1
            yield f"<msqrt>{''.join(_joined(elements[k + 1 : last + 1]))}</msqrt>"
            k = last
        elif element.kind == "space":
            if 0 < k < len(elements) - 1 and elements[k - 1].is_operand:
                yield _space(elements[k - 1], elements[k + 1])
        else:
            yield str(element)
        k += 1


def _space(left: _Element, right: _Element) -> str:
    if "text" in (left.kind, right.kind):
        return '<mspace width="0.3em"/>'
    separates = right.kind != "sign" or right.text in (*_OPENING, "|")
    return '<mspace width="0.17em"/>' if separates else ""


def _base(kind: str, text: str, after_operator: bool) -> str:
    """The element of a symbol without its scripts."""
    if kind == "gap":
        return '<mspace width="2em"/>'
    if kind == "matrix":
        return _matrix(text)
    if kind == "half":
        return "<mfrac><mn>1</mn><mn>2</mn></mfrac>"
    if kind == "sum":
        return "<mo>∑</mo>"
    if kind == "number":
        return f"<mn>{text}</mn>"
    if kind == "text":
        return f"<mtext>{text}</mtext>"
    if kind == "function":
        return f'<mi mathvariant="normal">{text}</mi>'
    return _letter(text) if kind == "letter" else _sign(text, after_operator)


def _matrix(text: str) -> str:
    """ "[a; b]": rows apart at semicolons. Spaces separate columns where a row has three or more."""
    rows = [_columns(row.strip()) for row in text[1:-1].split(";")]
    if len(rows[0]) < 3:
        rows = [[" ".join(row)] for row in rows]
    cells = ("".join(f"<mtd>{_row(cell)}</mtd>" for cell in row) for row in rows)
    table = "".join(f"<mtr>{row}</mtr>" for row in cells)
    return f"<mrow><mo>[</mo><mtable>{table}</mtable><mo>]</mo></mrow>"


def _columns(row: str) -> list[str]:
    """Its parts between spaces outside of parentheses."""
    return re.split(r" (?![^(]*\))", row)


def _letter(text: str) -> str:
    letter = f"<mi>{text[0]}</mi>"
    if len(text) == 1:
        return letter
    return f'<mover accent="true">{letter}<mo>{_ACCENTS[text[1]]}</mo></mover>'


def _sign(text: str, after_operator: bool) -> str:
    attributes = ' stretchy="false"' if text in _OPENING + _CLOSING else ""
    if text in _TIGHT:
        attributes = ' stretchy="false" lspace="0" rspace="0"'
    elif text in "−+±√∂∇" and after_operator:
        attributes = ' form="prefix" lspace="0" rspace="0"'
    elif text in "∂∇":
        attributes = ' lspace="0" rspace="0"'
    return f"<mo{attributes}>{escape(text)}</mo>"


def _script(text: str) -> str:
    """What is written small: "_ij", "_{e ∋ v}", "₀", "ⁿ⁺¹", "^½"."""
    if text == "^½":
        return "<mn>1/2</mn>"
    if text.startswith("_"):
        inner = text.strip("_{}")
        is_word = inner.isalpha() and len(inner) > 2
        return f"<mtext>{inner}</mtext>" if is_word else f"<mrow>{_row(_spread(inner))}</mrow>"
    plain = "".join((_LOWERED | _RAISED)[sign] for sign in text)
    return f"<mrow>{''.join(_small(sign) for sign in plain)}</mrow>"


def _spread(index: str) -> str:
    """Letters of an index apart, so that they are no word: "ij" is i and j."""
    return " ".join(index) if index.isalpha() else index


def _small(sign: str) -> str:
    tag = "mn" if sign.isdigit() else "mi" if sign.isalpha() else "mo"
    attributes = ' lspace="0" rspace="0"' if tag == "mo" else ""
    return f"<{tag}{attributes}>{sign}</{tag}>"
