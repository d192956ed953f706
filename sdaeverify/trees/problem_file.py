"""The problem that a failing condition is about, as a plugin file: an SDE with a component for each tree."""

from collections.abc import Iterable, Iterator, Sequence

from ..errors import UsageError
from .conditions import Condition
from .grow import DRIFT, TIME, Tree, closure
from .moments import ExactMoments

TEMPLATE = '''"""A problem on which an order condition of {scheme} fails.

The condition {name}{of_paths}: found {found}, wanted {wanted}, in units of h^({weight}/2).
Written by sdaeverify orders. Components are iterated integrals, one for each tree, and one that keeps errors from
being zero:

{components}
    x[{last}]  dx = -x dt + dW_1
"""

import numpy as np

from sdaeverify import SDE, Moment, hookimpl


def drift(t, x):
    """Return f(t, x), shape ({d}, P)."""
    f = np.zeros_like(x)
{drift}    f[{last}] = -x[{last}]
    return f


def diffusion(t, x):
    """Return B(t, x), shape ({d}, {motions}, {paths})."""
    B = np.zeros({shape})
{diffusion}    B[{last}, 0] = 1.0
    return B


def counterexample(horizon: float = 1.0) -> SDE:
    """The closure of {name} as a system: dx_i is the product of the components below it.

    Parameters
    ----------
    horizon : float
        Final time.

    Source
    ------
    The order condition of {name}.
    """
    return SDE(
        drift=drift,
        diffusion=diffusion,
        start=np.zeros({d}),
        noise_dim={motions},
        noise=frozenset({noise}),
        traits=frozenset({traits}),
        observables={{"{observable}": lambda t, s: {product}}},
        truths=(
            Moment(observable="{observable}", value=lambda t: {moment} * t ** {power}, source="Ito's formula"),
        ),
        horizon=horizon,
        source="order condition of {name}",
    )


@hookimpl
def sdaeverify_problems():
    """Register the problem."""
    return [counterexample]
'''


def problem_file(
    condition: Condition, scheme: str, motions: int, noise: Iterable[str], traits: frozenset[str]
) -> str:
    """Return the text of a plugin file with the closure of a condition's trees as a problem.

    Parameters
    ----------
    condition : Condition
    scheme : str
        Label of the scheme that it fails for.
    motions : int
        Number of Brownian motions.
    noise : iterable of str
        What the problem has drawn.
    traits : frozenset of str
        Of the class.

    Raises
    ------
    UsageError
        If the closure is no equation of the class, because its condition is one modulo relations.
    """
    trees = closure(condition.forest)
    if traits - {"additive-noise"} and not all(map(_vanishes, trees)):
        raise UsageError(
            f"the condition {condition.name} is one modulo relations, and the closure of no tree shows it"
        )
    found, wanted = condition.texts
    moment = ExactMoments().mean(condition.forest)
    constant = "additive-noise" in traits
    return TEMPLATE.format(
        scheme=scheme,
        name=condition.name,
        of_paths=" on each path" if condition.on_paths else "",
        found=found,
        wanted=wanted,
        weight=condition.weight,
        components="\n".join(f"    x[{i}]  {each}" for i, each in enumerate(trees)),
        last=len(trees),
        d=len(trees) + 1,
        motions=motions,
        paths="1" if constant else "P",
        shape=f"({len(trees) + 1}, {motions}, " + ("1)" if constant else "x.shape[1]), dtype=x.dtype"),
        drift="".join(_lines(trees, "f[{0}]", noisy=False)),
        diffusion="".join(_lines(trees, "B[{0}, {1}]", noisy=True)),
        noise=_set_text({"dW", "H", *noise}),
        traits=_set_text(traits),
        observable=condition.name,
        product=" * ".join(f's["x"][{trees.index(each)}]' for each in condition.forest),
        moment=f"{moment.numerator} / {moment.denominator}",
        power=condition.weight / 2,
    )


def _vanishes(each: Tree) -> bool:
    """Tell whether no noise node stands right above another one."""
    return each.colour <= DRIFT or all(kid.colour <= DRIFT for kid in each.kids)


def _lines(trees: Sequence[Tree], target: str, *, noisy: bool) -> Iterator[str]:
    for place, each in enumerate(trees):
        if (each.colour > DRIFT) == noisy:
            factors = ("t" if kid.colour == TIME else f"x[{trees.index(kid)}]" for kid in each.kids)
            yield f"    {target.format(place, each.colour - 1)} = {' * '.join(factors) or '1.0'}\n"


def _set_text(words: Iterable[str]) -> str:
    inside = ", ".join(f'"{word}"' for word in sorted(words))
    return f"{{{inside}}}" if inside else ""
