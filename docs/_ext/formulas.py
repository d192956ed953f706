"""Formulas of docstrings are plain text, which a terminal can show; a page typesets them: text is turned into TeX."""

import re
from collections.abc import Callable
from itertools import accumulate, groupby

from markup import prose, verbatim

GREEK = (
    *("alpha", "beta", "gamma", "delta", "zeta", "eta", "theta", "kappa", "lambda", "mu", "nu", "xi", "pi", "rho"),
    *("sigma", "tau", "phi", "chi", "psi", "omega", "Sigma", "Phi", "Gamma", "Pi"),
)
FUNCTIONS = ("exp", "log", "ln", "det", "min", "max", "sin", "cos", "tan", "sinh", "cosh")
NAMES = {
    "eps": r"\varepsilon ",
    "grad": r"\nabla ",
    "sum": r"\sum ",
    "int": r"\int ",
    "o": r"\circ ",
    "inf": r"\infty ",
    "kT": "k T",
    **{name: f"\\{name} " for name in (*GREEK, *FUNCTIONS)},
    **{name: rf"\operatorname{{{name}}}" for name in ("abs", "arsinh", "diag", "div", "tr")},
    **{name: rf"\text{{{name}}}" for name in ("Id", "Im", "Re", "const")},
    **{name: name for name in ("sqrt", "qquad", "tfrac", "hat", "pm", "sim", "langle", "rangle")},
}
SIGNS = {
    "<-": r"\\leftarrow ",
    "->": r"\\to ",
    "∈": r"\\in ",
    "!=": r"\\ne ",
    "+-": r"\\pm ",
    "-+": r"\\mp ",
    "<=": r"\\le ",
    ">=": r"\\ge ",
}
# From plain text to TeX, one after the other; words come last.
REWRITES = tuple(
    (re.compile(plain), sign)
    for plain, sign in (
        (r"(?<=\S)\s{2,}(?=[^\s=])", r" \\qquad "),
        *((rf"(?<=[\s_]){re.escape(plain)}(?=[\s\w])", sign) for plain, sign in SIGNS.items()),
        (r"<(\w+), (\w+)>", r"\\langle \1, \2 \\rangle "),
        (r"~", r"\\sim "),
        (r"_\+-", r"_{\\pm}"),
        (r"_([+-])(?=[\s,.)]|$)", r"_{\1}"),
        (r"\b(\w+)\+-(?=[\s,.)]|$)", r"\1^{\\pm}"),
        (r"\b(\w*[A-Za-z]\w*)([+-])(?=[\s,.)]|$)", r"\1^{\2}"),
        (r"\b([A-Za-z]+)\^(?=[\s,.)\]]|$)", r"\\hat{\1}"),
        (r"_([A-Za-z0-9]+)", r"_{\1}"),
        (r"\^\(([^()]*)\)", r"^{\1}"),
        (r"\^([A-Za-z0-9]+)", r"^{\1}"),
        (r"(?<!\w)\(([\w^{}]{1,12})/([\w^{}]{1,12})\)", r"\\tfrac{\1}{\2}"),
        (r"\{ ", r"\\{ "),
        (r" \}", r" \\}"),
    )
)
WORD = re.compile(r"(?<![\w\\])([A-Za-z]+)")
CODE = re.compile(r"(``.+?``|`[^`]+`)")
# What makes symbols in prose a formula.
OPERATOR = re.compile(rf"[=^~_<>]|[+-] |[A-Za-z]\+(?!\w)|\bd[Wwtx]\b|\b(?:{'|'.join((*GREEK, 'eps'))})\b")
# A formula begins and ends with a symbol, not with an article or a sign of punctuation.
EDGES = re.compile(r"(\s*(?:[aA] (?=[\w(]))?)(.*?)([\s.,;:]*)", re.DOTALL)
# English words, where they stand alone.
ENGLISH = {"sum", "min", "max", "do"}
# What ends a formula in prose; three dots do not.
STOP = re.compile(r"(?<!\.)[.;:]$")


def is_formula(text: str) -> bool:
    """Return whether a line is a formula and nothing else."""
    words = re.findall(r"[A-Za-z]+", re.sub(r"_[A-Za-z0-9]+", "", text))
    return None not in map(_as_name, words) and bool(re.search(r"[=<~]|[+] |dW", text))


def tex(text: str) -> str:
    """Return TeX of a formula that is written in plain text."""
    text = text.strip()
    for plain, sign in REWRITES:
        text = plain.sub(sign, text)
    return WORD.sub(lambda found: _as_name(found[1]) or found[1], _roots(text)).strip()


def _as_name(word: str) -> str | None:
    """Return TeX of a word that formulas use, or None."""
    if len(word) == 1 or word in NAMES:
        return NAMES.get(word, word)
    if word[0] in "dD" and (rest := _as_name(word[1:])) is not None:
        return rf"\,d{rest}" if word[0] == "d" else f"D{rest}"
    return None


def _roots(text: str) -> str:
    """Return the text with each square root around what its parentheses hold."""
    while (at := text.find("sqrt(")) >= 0:
        end, depth = at + 5, 1
        while depth and end < len(text):
            depth += {"(": 1, ")": -1}.get(text[end], 0)
            end += 1
        text = f"{text[:at]}\\sqrt{{{text[at + 5 : end - 1]}}}{text[end:]}"
    return text


def display(lines: list[str]) -> str:
    """Return TeX of a block of lines, one below the other."""
    first = min(len(line) - len(line.lstrip()) for line in lines)
    rows = (r"\qquad " * (len(line) - len(line.lstrip()) > first) + tex(line) for line in lines)
    return r"\begin{array}{l} " + r" \\ ".join(rows) + r" \end{array}" if len(lines) > 1 else tex(lines[0])


def typeset(text: str, mark: Callable[[str], str], plain: Callable[[str], str]) -> str:
    """Return prose in which each formula is marked as one, and all else but code is plain."""
    pieces = CODE.split(text)
    return "".join(piece if CODE.fullmatch(piece) else _marked(piece, mark, plain) for piece in pieces)


def _marked(text: str, mark: Callable[[str], str], plain: Callable[[str], str]) -> str:
    words = re.findall(r"\s*\S+|\s+$", re.sub(r" in (?=R\b|\{)", " ∈ ", text))
    sentences = accumulate((bool(STOP.search(word)) for word in words), initial=0)
    told = ""
    for (_, symbols), group in groupby(
        zip(sentences, words, strict=False), lambda pair: (pair[0], _is_symbol(pair[1].strip()))
    ):
        run = "".join(word for _, word in group)
        found = EDGES.fullmatch(run)
        if symbols and found and OPERATOR.search(found[2]) and _balanced(found[2]):
            told += plain(found[1]) + mark(tex(found[2])) + plain(found[3])
        else:
            told += plain(run)
    return told


def _is_symbol(word: str) -> bool:
    return word not in ENGLISH and is_formula(f"x + {word}")


def _balanced(text: str) -> bool:
    return all(text.count(left) == text.count(right) for left, right in ("()", "[]", "{}"))


def described(text: str) -> str:
    """Return Markdown of a docstring: formulas typeset, prose as prose, the sections below it as they are."""
    blocks = re.split(r"\n\s*\n", text)
    end = next((n for n, block in enumerate(blocks) if re.search(r"^-{3,}$", block, re.MULTILINE)), len(blocks))
    rest = "\n\n".join(blocks[end:])
    return "\n\n".join([*map(_paragraph, blocks[:end]), *([verbatim(rest)] if rest else [])])


def _paragraph(block: str) -> str:
    lines = block.splitlines()
    if all(map(is_formula, lines)):
        return f"$$\n{display(lines)}\n$$"
    if block.startswith("    "):
        return verbatim(block)
    return re.sub(r"^(?=\S)(.*)\n\s+", r"- \1: ", summary(block), flags=re.MULTILINE)


def summary(text: str) -> str:
    """Return Markdown of prose with formulas in it."""
    return typeset(text, lambda formula: f"${formula}$", prose)
