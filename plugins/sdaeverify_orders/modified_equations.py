"""Modified equations of a scheme, class by class."""

from collections.abc import Sequence
from pathlib import Path

from sdaeverify import Scheme, UsageError
from sdaeverify.studying import load_registry, select_schemes
from sdaeverify.trees import TreeClass

from .order_report import check_numbers, classes_named
from .trees.classes import EquationClass
from .trees.modified.equation import MOST_WEIGHT, ModifiedEquation, is_slow, modified_equation

MOTIONS = 2


def modified_of(
    scheme: Scheme, classes: str | Sequence[str] | None = None, motions: int = MOTIONS, weight: int | None = None
) -> list[ModifiedEquation]:
    """Return the modified equations of a scheme for classes with trees; see `modified_equations`.

    Parameters
    ----------
    scheme : Scheme
    classes : str or sequence of str, optional
    motions : int
    weight : int, optional
        As for `modified_equations`.

    Raises
    ------
    UsageError
        If a name is unknown or a number is out of its range.
    """
    check_numbers(motions, weight)
    if weight is not None and weight > MOST_WEIGHT:
        raise UsageError(f"weight must be at most {MOST_WEIGHT} for a modified equation, got {weight!r}")
    named = classes_named(scheme, classes)
    kinds = [kind for kind in named if isinstance(kind, EquationClass | TreeClass)]
    if classes is None:
        # Users must name classes that take minutes.
        kinds = [kind for kind in kinds if not is_slow(kind)]
    return [modified_equation(scheme, kind, motions, weight) for kind in kinds]


def modified_equations(
    scheme: str | Scheme,
    classes: str | Sequence[str] | None = None,
    motions: int = MOTIONS,
    weight: int | None = None,
    *,
    plugins: Sequence[str | Path] = (),
) -> list[ModifiedEquation]:
    """Return the modified equation of a scheme for each class, which the scheme solves with one order more.

    At weak order p, the means of a step are those of an equation with the drift f + h^p f_p and the covariance
    B B^T + h^p Q_p up to h^(p + 2), unless its expansion has derivatives of third or higher order.

    Parameters
    ----------
    scheme : str or Scheme
        A name with parameters, or a scheme itself, as for `verify`.
    classes : str or sequence of str, optional
        Names of classes with trees, as for `orders`. If omitted, all but those of index 1, which take minutes.
    motions : int
        Number of Brownian motions for classes that do not fix it.
    weight : int, optional
        Maximum weight of forests; 2 p + 2 is needed. If omitted, 6 unless there are more than 500 trees.
    plugins : sequence of str or Path, optional
        Plugin files, in addition to the installed plugins.

    Returns
    -------
    list of ModifiedEquation
        For a class that the scheme does not solve, `why_not` gives the reason.

    Raises
    ------
    UsageError
        If a name is unknown, matches several schemes, or a number is out of its range.
    """
    found = select_schemes(load_registry(plugins), scheme)
    if len(found) != 1:
        raise UsageError(f"modified_equations expects one scheme, got {scheme!r:.200}, which matches {len(found)}")
    return modified_of(found[0], classes, motions, weight)
