"""A modified equation as text: the equation, its terms as formulas, and pictures of their trees."""

from collections.abc import Iterable, Iterator, Sequence

from ..grow import picture
from .equation import GeneratorTerm, ModifiedEquation
from .laws import law_lines
from .notation import Notation
from .sums import Sum, summed

BESIDE = "   "


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
    notation, h = notation_of(of), _power(of.order)
    if of.obstruction:
        yield f"{about}: weak order {of.order:g}; no modified SDE at {h}: its generator would have"
        yield f"    {notation.sums(summed(of.obstruction, of.motions))}"
    else:
        yield f"{about}: weak order {of.order:g}; to one order more a step solves the equation with"
        yield from _components(of, notation, h)
    yield from (f"    {line}" for line in law_lines(of))
    if pictures:
        shown = of.obstruction or of.terms
        yield from (f"    {line}".rstrip() for line in _pictures(summed(shown, of.motions), notation))


def _power(order: float) -> str:
    return "1" if order == 0.0 else "h" if order == 1.0 else f"h^{order:g}"


def _components(of: ModifiedEquation, notation: Notation, h: str) -> Iterator[str]:
    """Yield the change of drift and covariance; for Langevin dynamics by positions and momenta."""
    if not notation.langevin:
        drift, covariance = (notation.sums(summed(terms, of.motions)) for terms in (of.drift, of.covariance))
        yield "    drift       f" + (f" + {h} ({drift})" if of.drift else "")
        yield "    covariance  B B^T" + (f" + {h} ({covariance})" if of.covariance else "")
    else:
        yield from _langevin(of, notation, h)
    if of.covariance:
        yield "    sym(a, b) = a b^T + b a^T"


def _langevin(of: ModifiedEquation, notation: Notation, h: str) -> Iterator[str]:
    exact = {"q": "p", "p": "F - gamma p"}
    for part, before in exact.items():
        terms = [each for each in of.drift if _part(each) == (part,)]
        yield f"    drift of {part}          {before} + {h} ({notation.sums(summed(terms, of.motions))})"
    for pair, before in ((("p", "p"), "sigma^2 + "), (("p", "q"), ""), (("q", "q"), "")):
        sums = summed((each for each in of.covariance if _part(each) == pair), of.motions)
        if (formula := notation.sums(sums)) != "0":
            yield f"    covariance of {','.join(pair)} {before}{h} ({formula})"


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
