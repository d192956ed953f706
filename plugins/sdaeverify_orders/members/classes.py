"""Classes of equations on which a scheme's claims are tested, and their random members."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from typing import Any

from sdaeverify import Claim, Scheme
from sdaeverify.errors import FAULTS
from sdaeverify.studying import match
from sdaeverify.trees import GenericClass

# A class is narrowed by at most this number of features, unless all of them are omitted.
FEATURES = 2


@dataclass(frozen=True)
class MemberClass:
    """A class of equations of a form, from which members are drawn.

    Attributes
    ----------
    of : GenericClass
        The widest class.
    without : frozenset of str
        Names of the features that no member has.
    """

    of: GenericClass
    without: frozenset[str] = frozenset()

    @property
    def name(self) -> str:
        """The name of the widest class, followed by the omitted features."""
        left_out = [feature for feature in self.of.features if feature in self.without]
        return f"{self.of.name} without {' and '.join(left_out)}" if left_out else self.of.name

    @property
    def features(self) -> tuple[str, ...]:
        """Names of the features that members have."""
        return tuple(feature for feature in self.of.features if feature not in self.without)

    def narrowed(self, feature: str) -> "MemberClass":
        """Return the class with one more feature omitted."""
        return MemberClass(self.of, self.without | {feature})


# All schemes of a run are tested on the same members, so the reference of a member is computed once.
@lru_cache(maxsize=64)
def member_of(kind: MemberClass, seed: int, index: int) -> Any:
    """Return a member of a class, the same for the same seed and index.

    Parameters
    ----------
    kind : MemberClass
    seed : int
        Of the run.
    index : int
    """
    return kind.of.member(seed, index, kind.without)


def member_classes(scheme: Scheme, seed: int) -> dict[MemberClass, tuple[Claim, ...]]:
    """Return the classes on which a scheme's claims are tested, each with its claims.

    A claim is tested on the widest class whose members have the claim's traits and are accepted by the scheme.

    Parameters
    ----------
    scheme : Scheme
    seed : int
        Of the run.
    """
    found: dict[MemberClass, tuple[Claim, ...]] = {}
    for generic in (kind for form in scheme.forms for kind in form.generic_classes()):
        for claim in scheme.promises:
            kind = next((each for each in _narrowings(generic) if _fits(scheme, claim, each, seed)), None)
            if kind is not None:
                found[kind] = (*found.get(kind, ()), claim)
    return found


def _narrowings(generic: GenericClass) -> Iterator[MemberClass]:
    """Yield the class and narrower ones, the widest first; the features named last are omitted first."""
    names = [*generic.features][::-1]
    for count in range(min(FEATURES, len(names)) + 1):
        for some in combinations(names, count):
            yield MemberClass(generic, frozenset(some))
    if len(names) > FEATURES:
        yield MemberClass(generic, frozenset(names))


def _fits(scheme: Scheme, claim: Claim, kind: MemberClass, seed: int) -> bool:
    return accepts(scheme, kind, seed) and claim.when <= member_of(kind, seed, 0).traits


def accepts(scheme: Scheme, kind: MemberClass, seed: int) -> bool:
    """Return whether a scheme solves the members of a class in the form of the class.

    Parameters
    ----------
    scheme : Scheme
    kind : MemberClass
    seed : int
        Of the run.
    """
    try:
        member = member_of(kind, seed, 0)
        return match(scheme, member).problem is member
    except FAULTS:
        # A form or a scheme that raises here is reported as an error by its own cells.
        return False
