"""A modified equation as text: the equation, its terms as formulas, and pictures of their trees."""

from collections.abc import Iterable, Iterator, Sequence

from ..grow import formula, picture
from .equation import GeneratorTerm, ModifiedEquation
from .laws import law_lines
from .notation import Notation
from .sums import Sum, summed

BESIDE = "   "
# Widths of the names of coefficients, for aligned formulas.
WIDTH, LANGEVIN = 12, 21


def notation_of(of: ModifiedEquation, *, latex: bool = False) -> Notation:
    """Return the notation for formulas of a modified equation.

    Parameters
    ----------
    of : ModifiedEquation
    latex : bool
        Whether formulas are LaTeX.
    """
    return Notation(latex, of.kind.startswith("langevin"), of.motions)


def lines_of_equation(of: ModifiedEquation, *, pictures: bool = True) -> Iterator[str]:
    """Yield the lines that describe a modified equation.

    Parameters
    ----------
    of : ModifiedEquation
    pictures : bool
        Whether to append drawings of the trees.
    """
    about = f"{of.scheme}, {of.kind}" + (f", {of.motions} motions" if of.motions > 1 else "")
    if of.why_not:
        yield f"{about}: no modified equation from trees: {of.why_not}"
        return
    if not of.terms:
        yield f"{about}: all means of forests up to the weight {of.top} hold; larger ones need --weight {of.top + 2}"
        return
    notation = notation_of(of)
    if of.obstruction:
        yield f"{about}: weak order {of.order:g}; no modified SDE at {_power(of.order)}: its generator would have"
        yield f"    {notation.sums(summed(of.obstruction, of.motions))}"
    else:
        more = "to one order more " if of.order else ""
        yield f"{about}: weak order {of.order:g}; {more}a step solves the equation with"
        yield from _components(of, notation)
    yield from (f"    {line}" for line in law_lines(of))
    if pictures:
        yield from (f"    {line}".rstrip() for line in _pictures(_shown(of), notation))


def _shown(of: ModifiedEquation) -> Sequence[Sum]:
    """Return the sums whose trees are drawn: those of the obstruction, if there is one."""
    return summed(of.obstruction or of.terms, of.motions)


def cells_of_equation(of: ModifiedEquation) -> tuple[str, str]:
    """Return a modified equation as two cells of a table: its lines, and its terms with their trees.

    Parameters
    ----------
    of : ModifiedEquation

    Returns
    -------
    tuple of str
        The second one has a line ``forest: formula`` for each term, such as ``f(b1,b1): -1/4 sum_j f''[b_j, b_j]``.
    """
    notation = notation_of(of)
    terms = [f"{formula(each.forest)}: {notation.term(each)}" for each in _shown(of)]
    return "\n".join(lines_of_equation(of, pictures=False)), "\n".join(terms)


def _power(order: float) -> str:
    return "h" if order == 1.0 else f"h^{order:g}"


def _added(before: str, formula: str, of: ModifiedEquation) -> str:
    """Return a coefficient with the change h^p (formula), which is the formula itself at order 0."""
    if of.order:
        return " + ".join(filter(None, (before, f"{_power(of.order)} ({formula})")))
    return before + (f" - {formula[1:]}" if formula.startswith("-") else f" + {formula}") if before else formula


def _components(of: ModifiedEquation, notation: Notation) -> Iterator[str]:
    """Yield the change of drift and covariance; for Langevin dynamics by positions and momenta."""
    if not notation.langevin:
        drift, covariance = (notation.sums(summed(terms, of.motions)) for terms in (of.drift, of.covariance))
        yield _line("drift", _added("f", drift, of) if of.drift else "f")
        yield _line("covariance", _added("B B^T", covariance, of) if of.covariance else "B B^T")
    else:
        yield from _langevin(of, notation)
    if of.covariance:
        yield "    sym(a, b) = a b^T + b a^T"


def _line(name: str, formula: str, width: int = WIDTH) -> str:
    return f"    {name.ljust(width)}{formula}"


def _langevin(of: ModifiedEquation, notation: Notation) -> Iterator[str]:
    exact = {"q": "p", "p": "F - gamma p"}
    for part, before in exact.items():
        terms = [each for each in of.drift if _part(each) == (part,)]
        formula = notation.sums(summed(terms, of.motions))
        yield _line(f"drift of {part}", before if formula == "0" else _added(before, formula, of), LANGEVIN)
    for pair, before in ((("p", "p"), "sigma^2"), (("p", "q"), ""), (("q", "q"), "")):
        sums = summed((each for each in of.covariance if _part(each) == pair), of.motions)
        if (formula := notation.sums(sums)) != "0":
            yield _line(f"covariance of {','.join(pair)}", _added(before, formula, of), LANGEVIN)


def _part(of: GeneratorTerm) -> tuple[str, ...]:
    return tuple(sorted("q" if each.name == "q" else "p" for each in of.forest))


def _pictures(sums: Iterable[Sum], notation: Notation) -> Iterator[str]:
    """Yield each term, followed by the pictures of its trees side by side."""
    for each in sums:
        yield ""
        yield notation.term(each)
        yield from beside([picture(tree) for tree in each.forest])


def beside(pictures: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield the lines of pictures placed side by side.

    Parameters
    ----------
    pictures : sequence of sequence of str
    """
    widths = [max(map(len, lines)) for lines in pictures]
    for row in range(max(map(len, pictures))):
        parts = [lines[row] if row < len(lines) else "" for lines in pictures]
        yield BESIDE.join(part.ljust(width) for part, width in zip(parts, widths, strict=True)).rstrip()


def record_of_equation(of: ModifiedEquation) -> dict[str, object]:
    """Return a modified equation as a record for JSON: numbers, and formulas as text and as LaTeX.

    Parameters
    ----------
    of : ModifiedEquation
    """
    notation, latex = notation_of(of), notation_of(of, latex=True)
    parts = {"drift": of.drift, "covariance": of.covariance, "obstruction": of.obstruction}
    formulas = {name: summed(terms, of.motions) for name, terms in parts.items() if terms}
    return {
        "scheme": of.scheme,
        "class": of.kind,
        "motions": of.motions,
        "order": of.order if of.terms else None,
        "why_not": of.why_not,
        **{name: notation.sums(sums) for name, sums in formulas.items()},
        "latex": {name: latex.sums(sums) for name, sums in formulas.items()},
        "law": [*law_lines(of)] if of.terms else [],
        "terms": [
            {"trees": [str(tree) for tree in each.forest], "value": each.value, "error": each.error}
            for each in of.terms
        ],
    }
