"""Verdicts on a scheme's claims, class by class: from order conditions, and from random members of its forms."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from operator import index
from pathlib import Path
from typing import TYPE_CHECKING

from sdaeverify import Scheme, Settings, UsageError
from sdaeverify.measuring import Measure, Verdict
from sdaeverify.studying import load_registry, select_measures, select_schemes, unknown
from sdaeverify.trees import TreeClass

from .class_row import RANDOM_MEMBERS, ClassRow
from .members.classes import MemberClass, member_classes, member_of
from .members.rows import member_rows, refuting_class
from .trees.classes import EquationClass, tree_classes_of
from .trees.conditions import INVARIANT, Condition
from .trees.problem_file import problem_file
from .trees.report import rows_of

if TYPE_CHECKING:
    import pandas as pd

MOST_MOTIONS, MOST_WEIGHT = 4, 8
SEED = Settings().seed
MEMBER = '''"""A random member of the class {name} on which {measure} of {scheme} is refuted.

Written by sdaeverify orders. The member has: {features}.
"""

{imports}


def counterexample() -> {form}:
    """Return the member.

    Source
    ------
    Drawn at random.
    """
    (kind,) = (kind for kind in {form}.generic_classes() if kind.name == "{kind}")
    return kind.member(seed={seed}, index=0, without={without})


@hookimpl
def sdaeverify_problems():
    """Register the problem."""
    return [counterexample]
'''


@dataclass(frozen=True)
class OrderReport:
    """Verdicts on the claims of a scheme, class by class.

    Attributes
    ----------
    scheme : Scheme
    rows : tuple of ClassRow
        One for each class and measure.
    measures : tuple of Measure
        Measures that judge random members.
    """

    scheme: Scheme
    rows: tuple[ClassRow, ...]
    measures: tuple[Measure, ...] = ()

    @classmethod
    def of(
        cls,
        scheme: Scheme,
        measures: Iterable[Measure] = (),
        classes: str | Sequence[str] | None = None,
        motions: int = 3,
        weight: int | None = None,
    ) -> "OrderReport":
        """Return the report on a scheme.

        Parameters
        ----------
        scheme : Scheme
        measures : iterable of Measure
            Measures that judge random members; without any, only order conditions are used.
        classes : str or sequence of str, optional
        motions : int
        weight : int, optional
            As for `orders`, which raises the same errors.
        """
        check_numbers(motions, weight)
        kinds, own = classes_named(scheme, classes), tuple(measures)
        trees = (kind for kind in kinds if not isinstance(kind, MemberClass))
        members = (kind for kind in kinds if isinstance(kind, MemberClass))
        rows = [*rows_of(scheme, trees, motions, weight)]
        rows += [row for kind in members for row in member_rows(scheme, kind, own, SEED)]
        return cls(scheme, tuple(rows), own)

    @property
    def table(self) -> "pd.DataFrame":
        """One row per claim and class: orders, numbers of conditions (held, all), first failing one, premises."""
        import pandas as pd  # noqa: PLC0415 - workers need no tables

        return pd.DataFrame([row.cells for row in self.rows])

    @property
    def failing(self) -> tuple[Condition, ...]:
        """The first failing condition of each claim that is refuted."""
        refuted = (row.first for row in self.rows if row.verdict is Verdict.REFUTED)
        return tuple(dict.fromkeys(first for first in refuted if first))

    @property
    def refuted_members(self) -> tuple[ClassRow, ...]:
        """The rows of the claims that random members refute."""
        refuted = (row for row in self.rows if row.verdict is Verdict.REFUTED)
        return tuple(row for row in refuted if row.conditions == RANDOM_MEMBERS)

    @property
    def premises(self) -> dict[str, str]:
        """The premises of each class, or why it does not apply."""
        return {row.kind: row.premise for row in self.rows}

    def to_problem(self, condition: Condition | ClassRow) -> str:
        """Return the text of a plugin file with a problem that refutes a claim, from a condition or a random member.

        Parameters
        ----------
        condition : Condition or ClassRow
            One of `failing`, or the first failing condition of another row; or one of `refuted_members`.

        Raises
        ------
        UsageError
            If it is neither, or if no single tree isolates the condition.
        """
        if isinstance(condition, ClassRow):
            return self._member_file(condition)
        row = next((row for row in self.rows if row.first == condition), None)
        if row is None:
            raise UsageError(f"condition {condition.name!r:.200} is not in this report")
        if row.measure == INVARIANT:
            raise UsageError(
                "no equation isolates a condition of the invariant measure: run matrix -m invariant -p double-well"
            )
        kind = classes_of(self.scheme)[row.kind]
        assert not isinstance(kind, MemberClass)
        return problem_file(condition, self.scheme, kind, max(1, row.motions))

    def _member_file(self, row: ClassRow) -> str:
        kind, measures = classes_of(self.scheme).get(row.kind), {each.name: each for each in self.measures}
        if not isinstance(kind, MemberClass) or row not in self.refuted_members:
            raise UsageError(f"no random member of {row.kind!r:.200} refutes a claim of this report")
        return member_file(self.scheme, kind, measures[row.measure], SEED)

    def __repr__(self) -> str:
        return self.table.to_string(index=False)


def orders(
    scheme: str | Scheme,
    classes: str | Sequence[str] | None = None,
    motions: int = 3,
    weight: int | None = None,
    *,
    plugins: Sequence[str | Path] = (),
) -> OrderReport:
    """Test a scheme's claims for all smooth equations of each class.

    One step on an equation whose components are rooted trees gives every elementary weight, up to rounding. For forms
    without trees, one step is made on random members.

    Parameters
    ----------
    scheme : str or Scheme
        A name with parameters, or a scheme itself, as for `verify`.
    classes : str or sequence of str, optional
        Out of ode, scalar, additive, diagonal, commutative, vanishing-milstein-term, general,
        overdamped-gradient for SDEs, langevin and langevin-gradient, index-1 and index-1-additive, HolonomicSDAE and
        other forms with random members, and classes of third-party forms; all if omitted.
    motions : int
        Number of Brownian motions for classes that do not fix it; the verdict holds for this number.
    weight : int, optional
        Maximum weight of trees and forests, where noise nodes count 1 and other nodes 2. If omitted, 2 p + 1 for a
        claimed order p, and one more if that is cheap.
    plugins : sequence of str or Path, optional
        Plugin files, in addition to the installed plugins.

    Returns
    -------
    OrderReport

    Raises
    ------
    UsageError
        If a name is unknown, matches several schemes, or a number is out of its range.
    """
    registry = load_registry(plugins)
    found = select_schemes(registry, scheme)
    if len(found) != 1:
        raise UsageError(f"orders expects one scheme, got {scheme!r:.200}, which matches {len(found)}")
    return OrderReport.of(found[0], select_measures(registry), classes, motions, weight)


def check_numbers(motions: int, weight: int | None) -> None:
    """Raise if a number given by the user is out of its range.

    Raises
    ------
    UsageError
        If `motions` or `weight` is not a whole number in its range.
    """
    if not 1 <= _whole("motions", motions) <= MOST_MOTIONS:
        raise UsageError(f"motions must be from 1 to {MOST_MOTIONS}, got {motions!r}")
    if weight is not None and not 1 <= _whole("weight", weight) <= MOST_WEIGHT:
        raise UsageError(f"weight must be from 1 to {MOST_WEIGHT}, got {weight!r}")


def _whole(name: str, value: object) -> int:
    try:
        return index(None if isinstance(value, bool) else value)  # type: ignore[arg-type] # this line checks the type
    except TypeError:
        raise UsageError(f"{name} must be a whole number, got {value!r:.200}") from None


def classes_of(scheme: Scheme) -> dict[str, EquationClass | TreeClass | MemberClass]:
    """Return the classes that apply to a scheme, with trees or with random members, by name."""
    return {kind.name: kind for kind in (*tree_classes_of(scheme), *member_classes(scheme, SEED))}


def classes_named(scheme: Scheme, names: str | Sequence[str] | None) -> list[EquationClass | TreeClass | MemberClass]:
    """Return the classes of the given names, which may be one text separated by commas; all if `names` is None.

    Raises
    ------
    UsageError
        If a name is unknown.
    """
    known = classes_of(scheme)
    wanted = known if names is None else names.split(",") if isinstance(names, str) else names
    for name in wanted:
        if name not in known:
            raise UsageError(f"{unknown('class', name, known)} (known: {', '.join(known)})")
    return [known[name] for name in wanted]


def member_file(scheme: Scheme, kind: MemberClass, measure: Measure, seed: int) -> str:
    """Return the text of a plugin file with a member that has only the features needed to refute a claim.

    Parameters
    ----------
    scheme : Scheme
    kind : MemberClass
        A class on whose members a claim is refuted.
    measure : Measure
        Of the claim.
    seed : int
        Of the run.
    """
    narrowest = refuting_class(scheme, kind, measure, seed)
    form = type(member_of(narrowest, seed, 0))
    words = [kind.of.features[feature] for feature in narrowest.features]
    return MEMBER.format(
        name=kind.name,
        measure=measure.name,
        scheme=scheme.label,
        features=", ".join(words) or "none of the features of the class",
        imports=_imports(form),
        form=form.__name__,
        kind=kind.of.name,
        seed=seed,
        without=[feature for feature in kind.of.features if feature in narrowest.without],
    )


def _imports(form: type) -> str:
    module = form.__module__
    if module.startswith("sdaeverify."):
        return f"from sdaeverify import {form.__name__}, hookimpl"
    return f"from {module} import {form.__name__}\nfrom sdaeverify import hookimpl"
