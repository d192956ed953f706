"""Elementary differentials and modified equations as formulas, in plain text or LaTeX."""

from collections.abc import Sequence
from dataclasses import dataclass

from ..grow import DRIFT, TIME, Tree
from .numbers import number_words, recognised
from .sums import Sum

INDICES = "jklmn"
# Nodes of Langevin dynamics: a position whose child is a momentum equals that momentum, and d(m) = -gamma m.
MOVED, FRICTION = "q", "d"


@dataclass(frozen=True)
class Notation:
    """Notation of formulas.

    Attributes
    ----------
    latex : bool
        Whether formulas are LaTeX; otherwise plain text.
    langevin : bool
        Whether trees are those of Langevin dynamics, dq = p dt and dp = (F - gamma p) dt + sigma dW.
    motions : int
        Number of Brownian motions; a single motion has no index.
    """

    latex: bool = False
    langevin: bool = False
    motions: int = 2

    def sums(self, terms: Sequence[Sum]) -> str:
        """Return a sum of terms as a formula with equal terms merged, or 0.

        Trees of Langevin dynamics that differ only in the position of friction nodes are equal.
        """
        values: dict[tuple[str, str], tuple[float, float]] = {}
        for each in terms:
            (value, error), rest = self._signed(each), self._rest(each)
            before, others = values.get(rest, (0.0, 0.0))
            values[rest] = before + value, others + error
        parts = [self._with(*found, *rest) for rest, found in values.items() if abs(found[0]) > found[1]]
        first, *further = parts or ["0"]
        return first + "".join(f" - {part[1:]}" if part.startswith("-") else f" + {part}" for part in further)

    def term(self, of: Sum) -> str:
        """Return a term as a formula: coefficient, sum over motions, and a derivative with one argument per tree."""
        return self._with(*self._signed(of), *self._rest(of))

    def _signed(self, of: Sum) -> tuple[float, float]:
        return of.value * (-1.0) ** sum(map(self._friction, of.forest)), of.error

    def _rest(self, of: Sum) -> tuple[str, str]:
        power, gamma = sum(map(self._friction, of.forest)), "\\gamma" if self.latex else "gamma"
        friction = "" if not power else gamma if power == 1 else f"{gamma}^{power}"
        return friction, " ".join(filter(None, (self._sum(of), self._derivative(of))))

    def _with(self, value: float, error: float, friction: str, rest: str) -> str:
        text = " ".join(filter(None, (self._number(value, error), friction, rest)))
        return text[2:] if text.startswith("1 ") else f"-{text[3:]}" if text.startswith("-1 ") else text

    def _number(self, value: float, error: float) -> str:
        exact = recognised(value, error)
        if not self.latex or exact is None or exact[1] or exact[0].denominator == 1:
            return number_words(value, error)
        sign = "-" if value < 0.0 else ""
        return f"{sign}\\tfrac{{{abs(exact[0].numerator)}}}{{{exact[0].denominator}}}"

    def _sum(self, of: Sum) -> str:
        if not of.indices:
            return ""
        names = (" \\ne " if self.latex else "!=").join(INDICES[: of.indices]) if of.distinct else None
        names = names or ",".join(INDICES[: of.indices])
        return f"\\sum_{{{names}}}" if self.latex else f"sum_{names}" if of.indices == 1 else f"sum_({names})"

    def _derivative(self, of: Sum) -> str:
        """Return the factor of the coefficient: a vector, a symmetric matrix, or a derivative of u."""
        forest = sorted(of.forest, key=lambda each: self.langevin and each.name == MOVED)
        parts = [self.differential(each, summed=of.indices > 0) for each in forest]
        if self.langevin and len(forest) == 2 and forest[0].name != MOVED == forest[1].name:
            return f"({parts[0]}) ({parts[1]})^T"
        if len(parts) == 1:
            return parts[0]
        if len(parts) == 2:
            name = "\\operatorname{sym}" if self.latex else "sym"
            return f"{name}({', '.join(parts)})"
        return f"D^{len(parts)} u[{', '.join(parts)}]"

    def differential(self, of: Tree, *, summed: bool = False) -> str:
        """Return an elementary differential, as ``f''[b_j, b_j]``; for Langevin dynamics without powers of -gamma.

        Parameters
        ----------
        of : Tree
        summed : bool
            Whether the numbers of noise nodes denote summation indices.
        """
        if self.langevin and of.name in (MOVED, FRICTION):
            return self.differential(of.kids[0], summed=summed)
        kids = [each for each in of.kids if each.colour != TIME]
        head = self._head(of, len(of.kids) - len(kids), summed=summed)
        if not kids:
            return head
        primes = "'" * len(kids) if len(kids) < 4 else f"^({len(kids)})"
        if self.latex and len(kids) >= 4:
            primes = f"^{{({len(kids)})}}"
        below = [self.differential(each, summed=summed) for each in kids]
        return f"{head}{primes}" + (f"[{', '.join(below)}]" if len(kids) > 1 else f" {below[0]}")

    def _head(self, of: Tree, times: int, *, summed: bool) -> str:
        plain = "F" if self.langevin and of.root == "f" else of.root
        head = self._noise(of, summed=summed) if of.colour > DRIFT else plain
        if not times:
            return head
        by_time = ("\\partial_t" if self.latex else "d_t") + (f"^{times}" if times > 1 else "")
        return f"({by_time} {head})"

    def _noise(self, of: Tree, *, summed: bool) -> str:
        index = INDICES[of.colour - 1] if summed else str(of.colour)
        if self.langevin:
            return f"\\sigma e_{index}" if self.latex else f"sigma e_{index}"
        name = of.name or "b"
        return name if self.motions <= 1 else f"{name}_{index}"

    def _friction(self, of: Tree) -> int:
        """Return the power of -gamma in a tree of Langevin dynamics."""
        return (self.langevin and of.name == FRICTION) + sum(map(self._friction, of.kids))
