"""What a gate runs."""

from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

from facade import SCHEMES, TIERS, Origin, Policy, Registered, gate_plan
from sdaeverify import Control, Pathwise, UsageError, in_matrix
from sdaeverify.measuring import Verdict

from .conftest import SHARP, WEAKER, Fussy, Plain, added, line, plane, problem, registered


class Weak(Plain):
    name: ClassVar[str] = "weak"
    claims: ClassVar[tuple] = (WEAKER,)


class Picky(Plain):
    name: ClassVar[str] = "picky"
    claims: ClassVar[tuple] = (replace(SHARP, when=frozenset({"algebraic"})),)


class Asked(Plain):
    name: ClassVar[str] = "asked"
    on_request: ClassVar[bool] = True


class Bridged(Plain):
    name: ClassVar[str] = "bridged"
    claimant: ClassVar[str] = "a-library"


def known():
    truth = Pathwise(
        start=lambda paths: np.ones((2, paths)),
        advance=lambda x, t, h, noise: x + noise.dW,
        parts=lambda t, x: {"x": x},
        source="made up",
    )
    return problem(2, truths=(truth,))


def told():
    orders = (0.5, 1.0, 1.5)
    return problem(
        controls=tuple(Control(measure="sharp", order=p, positive="plain", negative="weak") for p in orders)
    )


def cells(registry, **policy):
    plan = gate_plan(registry, Policy(**policy))
    return {(cell.scheme.label, cell.spec.label, cell.measure.name) for cell in plan.cells}


def test_claimed_cells_only():
    """A cell is run where a claim of its measure is in scope."""
    assert cells(registered((Plain(), Picky()))) == {("plain", name, "sharp") for name in ("line", "added", "plane")}


@in_matrix({}, schemes=["fussy"], measures=["sharp"])
def dear():
    return problem()


def test_a_problem_may_be_there_for_some_schemes_alone():
    """A run of everything crosses it with these; asked for by name, or by a glob, it has all."""
    registry = registered((Plain(), Fussy()), (line, dear))
    everyone = {("plain", "dear", "sharp"), ("fussy", "dear", "sharp")}

    assert {cell for cell in cells(registry) if cell[1] == "dear"} == {("fussy", "dear", "sharp")}
    assert cells(registry, problems=("dear",)) == everyone
    assert cells(registry, problems=("de*",)) == everyone


def test_every_claim_once():
    """Each claim is where weaker schemes do not claim it, then on the smallest problem on which it counts."""
    assert cells(registered(), tier="smoke") == {
        ("plain", "line", "sharp"),  # fussy claims as much on added; before plane by its size
        ("fussy", "added", "sharp"),  # the stronger claim
        ("fussy", "line", "sharp"),  # the weaker one, which does not count on added
    }


def test_known_paths_come_first():
    """A problem with a pathwise truth is taken before one with fewer components."""
    assert cells(registered((Plain(),), (line, known)), tier="smoke") == {("plain", "known", "sharp")}


def test_where_weaker_schemes_would_pass_comes_last():
    """A problem on which a weaker scheme claims the order, too, is taken after one on which it claims less."""

    class Strong(Plain):
        name: ClassVar[str] = "strong"

    class Half(Plain):
        name: ClassVar[str] = "half"
        claims: ClassVar[tuple] = (WEAKER, replace(SHARP, when=frozenset({"additive-noise"})))

    assert cells(registered((Strong(),)), tier="smoke") == {("strong", "added", "sharp")}
    together = cells(registered((Strong(), Half())), tier="smoke")
    assert {cell for cell in together if cell[0] == "strong"} == {("strong", "line", "sharp")}


def test_every_variant():
    """Variants of a scheme are covered each by itself."""
    assert cells(registered((Plain(), Plain("odd"))), tier="smoke") == {
        ("plain", "added", "sharp"),
        ("plain[kind=odd]", "added", "sharp"),
    }


def test_error_is_kept():
    """A problem that cannot be built stays in every tier, as an error of the cells that claim something."""

    def broken():
        raise ValueError("no such thing")

    broken.__module__ = __name__
    plan = gate_plan(registered((Plain(),), (line, broken)), Policy(tier="smoke"))

    assert {(c.spec.label, c.verdict) for c in plan.cells} == {("line", None), ("broken", Verdict.ERROR)}


def test_own_schemes():
    """Without patterns the schemes of the project's own distribution are gated, and everything without a project."""
    registry = registered((Plain(),))
    other = Origin("theirs", "other", "1", "module")
    schemes = {**registry.schemes, "fussy": Registered("fussy", (Fussy(),), other)}
    both = replace(registry, entries={**registry.entries, SCHEMES: schemes})

    assert {scheme for scheme, *_ in cells(both, distribution="Pack")} == {"plain"}
    with pytest.raises(UsageError, match="project unknown registers no scheme here; install it"):
        cells(both, distribution="unknown")
    assert {scheme for scheme, *_ in cells(both)} == {"plain", "fussy"}
    assert {scheme for scheme, *_ in cells(both, distribution="Pack", schemes=("fussy",))} == {"fussy"}


def test_what_is_run_on_request_is_gated_where_it_is_named():
    """Without a project, a scheme that is run on request is gated by its name alone; its own project takes it."""
    registry = registered((Plain(), Asked()))

    assert {scheme for scheme, *_ in cells(registry)} == {"plain"}
    assert {scheme for scheme, *_ in cells(registry, schemes=("asked",))} == {"asked"}
    assert {scheme for scheme, *_ in cells(registry, distribution="Pack")} == {"plain", "asked"}


def test_claims_of_a_library_are_its_own():
    """A scheme that speaks for another project is gated there, whoever registers it."""
    registry = registered((Plain(), Bridged()))

    assert {scheme for scheme, *_ in cells(registry, distribution="pack")} == {"plain"}
    assert {scheme for scheme, *_ in cells(registry, distribution="A.Library")} == {"bridged"}


def test_schemes_of_plugin_files():
    """Schemes of a file that is named as a plugin belong to the project, too."""
    registry = registered((Plain(),))
    file = Origin("mine", "", "", "/somewhere/mine.py")
    schemes = {**registry.schemes, "fussy": Registered("fussy", (Fussy(),), file)}
    both = replace(registry, entries={**registry.entries, SCHEMES: schemes})

    assert {scheme for scheme, *_ in cells(both, plugins=("/somewhere/mine.py",))} == {"fussy"}


def test_instances():
    """Schemes and problems need not be registered."""
    assert cells(registered(()), schemes=(Plain("odd"),), problems=(plane,)) == {
        ("plain[kind=odd]", "plane", "sharp")
    }


def test_largest_first():
    """Problems with more work come first, so that workers end together."""
    plan = gate_plan(registered((Plain(),)), Policy())

    assert plan.problems[0].spec.label == "plane"


def test_controls():
    """Only controls of claimed orders are run; of the others it is known that they are declared."""
    registry = registered((Plain(), Weak()), (told,))
    (made,) = gate_plan(registry, Policy(schemes=("plain",))).problems

    assert [(plan.control.order, plan.missing) for plan in made.controls] == [
        (0.5, "no claim requires it"),
        (1.0, ""),
        (1.5, "no claim requires it"),
    ]


def test_controls_of_claims_between():
    """A claim of 3/4 runs the controls of the declared orders on both sides of it."""

    class Between(Plain):
        name: ClassVar[str] = "between"
        claims: ClassVar[tuple] = (replace(SHARP, value=0.75),)

    registry = registered((Plain(), Weak(), Between()), (told,))
    (made,) = gate_plan(registry, Policy(schemes=("between",))).problems

    assert [plan.missing for plan in made.controls] == ["", "", "no claim requires it"]


def test_no_controls_at_the_smallest_tier():
    """The smallest tier runs nothing but what is claimed."""
    (made,) = gate_plan(registered((Plain(), Weak()), (told,)), Policy(tier="smoke", schemes=("plain",))).problems

    assert made.controls == ()


@pytest.mark.parametrize("tier", TIERS)
def test_settings(tier):
    """Seed and error probability are those of the policy, the budget that of the tier."""
    settings = Policy(tier=tier, seed=5, alpha=0.001).settings

    assert (settings.seed, settings.confidence) == (5, 0.999)
    assert settings.paths == TIERS[tier].settings.paths


def test_tiers_grow():
    """A larger tier has no smaller budget, and every tier has the paths that a refutation takes."""
    paths = [TIERS[name].settings.paths for name in ("smoke", "ci", "nightly")]

    assert paths == sorted(paths)
    assert paths[0] >= 800


def test_nothing_claimed():
    """Where nothing is claimed nothing is planned."""
    assert gate_plan(registered((Plain(),), (added,)), Policy(measures=("blunt",))).problems == ()
