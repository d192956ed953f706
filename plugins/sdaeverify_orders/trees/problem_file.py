"""The problem of a failing condition as a plugin file: an equation with one component for each tree."""

from collections.abc import Iterable, Iterator, Sequence

from sdaeverify import Scheme, UsageError
from sdaeverify.trees import Grove, TreeClass, Written

from .classes import EquationClass
from .conditions import Condition
from .grow import DRIFT, TIME, Tree, closure
from .moments import ExactMoments
from .posed.grammar import grove_of, integral, without_scaled

TEMPLATE = '''"""A problem on which an order condition of {scheme} fails.

The condition {name}{of_paths}: found {found}, wanted {wanted}, in units of h^({weight}/2).
Written by sdaeverify orders. The components, one for each tree, and what keeps errors from being zero:

{components}
"""

import numpy as np

{imports}


{functions}

def counterexample(horizon: float = 1.0) -> {form}:
    """The closure of {name} as a system.

    Parameters
    ----------
    horizon : float
        Final time.

    Source
    ------
    The order condition of {name}.
    """
    return {form}(
{arguments}
        noise=frozenset({noise}),
        traits=frozenset({traits}),
{truths}        horizon=horizon,
        source="order condition of {name}",
    )


@hookimpl
def sdaeverify_problems():
    """Register the problem."""
    return [counterexample]
'''
# Factor of scaled nodes.
NUMBER = -0.5
OF_SDE = '''def drift(t, x):
    """Return f(t, x), shape ({d}, P)."""
    f = np.zeros_like(x)
{drift}    f[{last}] = -x[{last}]
    return f


def diffusion(t, x):
    """Return B(t, x), shape ({d}, {motions}, {paths})."""
    B = np.zeros({shape})
{diffusion}    B[{last}, 0] = 1.0
    return B
'''
TRUTHS = """        observables={{"{observable}": lambda t, s: {product}}},
        truths=(
            Moment(observable="{observable}", value=lambda t: {moment} * t ** {power}, source="Ito's formula"),
        ),
"""


def problem_file(condition: Condition, scheme: Scheme, kind: EquationClass | TreeClass, motions: int) -> str:
    """Return the text of a plugin file with the closure of a condition's trees as a problem.

    Parameters
    ----------
    condition : Condition
    scheme : Scheme
        Scheme for which the condition fails, and whose noise the problem declares.
    kind : EquationClass or TreeClass
        Class of the condition.
    motions : int
        Number of Brownian motions.

    Raises
    ------
    UsageError
        If the class has no such problem.
    """
    written: Written | None
    if isinstance(kind, EquationClass):
        trees = closure(condition.forest)
        written = _written(condition, trees, motions, kind.traits)
    else:
        trees = closure(without_scaled(each, kind.nodes) for each in condition.forest)
        written = kind.written(grove_of(trees, kind.nodes, Grove((), motions, NUMBER, 0.0)))
    if written is None:
        raise UsageError(
            f"conditions of {kind.name} have no problem file; sdaeverify hunt {scheme.label} searches for a problem "
            "on which the claim fails"
        )
    found, wanted = condition.texts
    lines = [f"    {place}  {each}" for place, each in zip(written.components, trees, strict=True)]
    return TEMPLATE.format(
        scheme=scheme.label,
        name=condition.name,
        of_paths=" on each path" if condition.on_paths else "",
        found=found,
        wanted=wanted,
        weight=condition.weight,
        components="\n".join([*lines, *(f"    {line}" for line in written.beside)]),
        imports="\n".join(_imports(written)),
        form=written.form,
        functions=written.functions,
        arguments="\n".join(f"        {name}={value}," for name, value in written.arguments.items()),
        noise=_set_text({"dW", "H", *scheme.noise}),
        traits=_set_text(written.traits),
        truths=_truths(condition, trees, written) if written.exact else "",
    )


def _imports(written: Written) -> Iterator[str]:
    names = {"sdaeverify": ["Moment", "hookimpl"] if written.exact else ["hookimpl"]}
    names.setdefault(written.module, []).insert(0, written.form)
    yield from (f"from {module} import {', '.join(some)}" for module, some in sorted(names.items()))


def _truths(condition: Condition, trees: Sequence[Tree], written: Written) -> str:
    """Return source text of the truth: the exact mean of the product of the integrals of a condition's trees."""
    moment = ExactMoments().mean_of_product([integral(each) for each in condition.forest])
    places = (written.components[trees.index(each)] for each in condition.forest)
    return TRUTHS.format(
        observable=condition.name,
        product=" * ".join(f's["{place[0]}"]{place[1:]}' for place in places),
        moment=f"{moment.numerator} / {moment.denominator}",
        power=condition.weight / 2,
    )


def _written(condition: Condition, trees: Sequence[Tree], motions: int, traits: frozenset[str]) -> Written:
    """Return the closure of a condition's trees as an SDE.

    Raises
    ------
    UsageError
        If the closure is not an equation of the class, because the condition is one modulo relations.
    """
    if traits - {"additive-noise"} and not all(map(_vanishes, trees)):
        raise UsageError(
            f"the condition {condition.name} holds modulo relations only, so that the closure of no tree isolates it"
        )
    constant, last = "additive-noise" in traits, len(trees)
    functions = OF_SDE.format(
        d=last + 1,
        last=last,
        motions=motions,
        paths="1" if constant else "P",
        shape=f"({last + 1}, {motions}, " + ("1)" if constant else "x.shape[1]), dtype=x.dtype"),
        drift="".join(_lines(trees, "f[{0}]", noisy=False)),
        diffusion="".join(_lines(trees, "B[{0}, {1}]", noisy=True)),
    )
    arguments = {"drift": "drift", "diffusion": "diffusion", "start": f"np.zeros({last + 1})", "noise_dim": motions}
    components = tuple(f"x[{place}]" for place in range(last))
    return Written("SDE", functions, arguments, components, (f"x[{last}]  dx = -x dt + dW_1",), traits)


def _vanishes(each: Tree) -> bool:
    """Return whether no noise node has another noise node as a child."""
    return each.colour <= DRIFT or all(kid.colour <= DRIFT for kid in each.kids)


def _lines(trees: Sequence[Tree], target: str, *, noisy: bool) -> Iterator[str]:
    for place, each in enumerate(trees):
        if (each.colour > DRIFT) == noisy:
            factors = ("t" if kid.colour == TIME else f"x[{trees.index(kid)}]" for kid in each.kids)
            yield f"    {target.format(place, each.colour - 1)} = {' * '.join(factors) or '1.0'}\n"


def _set_text(words: Iterable[str]) -> str:
    inside = ", ".join(f'"{word}"' for word in sorted(words))
    return f"{{{inside}}}" if inside else ""
