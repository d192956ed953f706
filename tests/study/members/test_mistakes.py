"""Mistakes in masses, Gram matrices and curvature are named on members, each rightly, and no right scheme is."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest

from facade import (
    ConstrainedEuler,
    HalfExplicitEuler,
    MemberClass,
    Strong,
    load_registry,
    member_mistake,
    member_of,
    member_rows,
)
from sdaeverify import (
    Array,
    Claim,
    ConstrainedLangevin,
    HolonomicSDAE,
    HolonomicState,
    Increment,
    Scheme,
    Step,
)
from sdaeverify.measuring import Verdict

SEED = 11
(MECHANICS,) = (MemberClass(kind) for kind in HolonomicSDAE.generic_classes())
KEPT, PENALISED = (MemberClass(kind) for kind in ConstrainedLangevin.generic_classes())
DICTIONARY = [each for kind in (MECHANICS, KEPT, PENALISED) for each in kind.of.mistakes]
CLASSES = {"motion": MECHANICS, "kept": KEPT, "penalised": PENALISED}


def gram(Dg, other, cut="whole"):
    """Return Dg other^T, or its diagonal, as matrices of shape (P, m, m)."""
    G = np.einsum("inp,njp->pij", Dg, other)
    return G * np.eye(len(Dg)) if cut == "diagonal" else G


def solve(G, b):
    """Solve for one right-hand side on each path."""
    return np.linalg.solve(G, b.T[..., None])[..., 0].T


@dataclass(frozen=True)
class Motion(HalfExplicitEuler):
    """The half-explicit scheme, written out, with one of its lines changed.

    Attributes
    ----------
    force_mass, noise_mass, push_mass, gram_mass : bool
        Whether M^-1 stands before the force, before the noise, in constraint forces, and in the Gram matrix.
    cut : str
        What is solved with: the ``whole`` Gram matrix or its ``diagonal``.
    place : str
        Where the tangent space is that the velocity goes to: the ``new`` position, or the ``old`` one.
    curved : float
        Factor of h D^2 g(v, v), which the old one needs.
    variance : float
        Of the noise.
    """

    truncation: str | float = "none"
    force_mass: bool = True
    noise_mass: bool = True
    push_mass: bool = True
    gram_mass: bool = True
    cut: str = "whole"
    place: str = "new"
    curved: float = 1.0
    variance: float = 1.0

    name: ClassVar[str] = "motion"

    def step(self, problem: HolonomicSDAE, state: HolonomicState, t: float, h: float, noise: Increment) -> Step:
        """Make one step: the position as it is meant, then the velocity."""
        right = HalfExplicitEuler(truncation="none").step(problem, state, t, h, noise)
        r, v, mu = state
        a, b = h * problem.force(t, r, v), np.sqrt(self.variance) * problem.diffused(t, r, v, noise.dW)
        u = (
            v
            + (problem.inverse_mass(a) if self.force_mass else a)
            + (problem.inverse_mass(b) if self.noise_mass else b)
        )
        old = np.broadcast_to(problem.dg(r), (problem.constraints, *r.shape)).swapaxes(0, 1)
        new = np.broadcast_to(problem.dg(right.state.r if self.place == "new" else r), old.swapaxes(0, 1).shape)
        G = gram(new, problem.inverse_mass(old) if self.gram_mass else old, self.cut)
        bent = h * self.curved * problem.d2g(r, v, v) if self.place == "old" else 0.0
        lam = -solve(G, np.einsum("inp,np->ip", new, u) + bent)
        pushed = np.einsum("nip,ip->np", problem.inverse_mass(old) if self.push_mass else old, lam)
        return Step(HolonomicState(right.state.r, u + pushed, mu + lam), right.failed)


@dataclass(frozen=True)
class Dynamics(Scheme):
    """Euler's method for the limit, or for the penalised equation, with one of its terms changed.

    Attributes
    ----------
    cut : str
        Gram matrix that is solved with: ``whole``, ``diagonal`` or ``none``.
    curved : float
        Factor of the curvature term, or of the Fixman term.
    along : bool
        Whether the drift is projected.
    """

    cut: str = "whole"
    curved: float = 1.0
    along: bool = True

    name: ClassVar[str] = "dynamics"
    form: ClassVar[type] = ConstrainedLangevin
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="strong", value=0.5, source="test"),)

    def step(self, problem: ConstrainedLangevin, state: Array, t: float, h: float, noise: Increment) -> Step:
        """Make one step."""
        at, sigma, f = problem.near(state), problem.strength, problem.drift(state)
        Dg = problem.dg(state)

        def back(c):
            whole = gram(Dg, Dg.swapaxes(0, 1), self.cut)
            return np.einsum("inp,ip->np", Dg, c if self.cut == "none" else solve(whole, c))

        def tangent(y):
            return y - back(np.einsum("inp,np->ip", Dg, y))

        if problem.eps:
            f = f + 0.25 * self.curved * sigma**2 * at.fixman - back(at.zeta) / problem.eps
            return Step(state + h * f + sigma * noise.dW)
        traces = np.zeros_like(at.zeta)
        for unit in np.eye(len(state)):
            e = np.broadcast_to(unit[:, None], state.shape)
            traces = traces + np.einsum("kdp,dp->kp", problem.turn_normals(state, tangent(e)), e)
        moved = (tangent(f) if self.along else f) - 0.5 * self.curved * sigma**2 * back(traces)
        return Step(state + h * moved + sigma * tangent(noise.dW))


def said(scheme, kind, index=0):
    """Return what is said of a scheme on a member of a class."""
    return member_mistake(scheme, kind, member_of(kind, SEED, index))


M = "mass matrix is left out"
MOTIONS = {
    "force and noise": (Motion(force_mass=False, noise_mass=False), f"{M}, M^-1 is meant: a dt + B dw moves"),
    "force": (Motion(force_mass=False), f"{M}, M^-1 is meant in front of the force"),
    "noise": (Motion(noise_mass=False), f"{M}, M^-1 is meant in front of the noise"),
    "push": (Motion(push_mass=False), f"{M}, M^-1 is meant in the constraint forces"),
    "inner": (Motion(gram_mass=False), f"{M}, M^-1 is meant in the Gram matrix"),
    "both": (Motion(gram_mass=False, push_mass=False), f"{M}, M^-1 is meant in constraint forces and Gram"),
    "all": (
        Motion(force_mass=False, noise_mass=False, gram_mass=False, push_mass=False),
        f"{M}, M^-1 is meant everywhere",
    ),
    "diagonal": (Motion(cut="diagonal"), "the Gram matrix is cut to its diagonal"),
    "flat": (Motion(place="old", curved=0.0), "the curvature term D^2 g(v, v) is left out"),
    "sign": (Motion(place="old", curved=-1.0), "the curvature term D^2 g(v, v) has the wrong sign"),
    "half": (Motion(place="old", curved=0.5), "the curvature term D^2 g(v, v) is halved"),
    "twice": (Motion(place="old", curved=2.0), "the curvature term D^2 g(v, v) is doubled"),
}
ON = {
    "flat": (Dynamics(curved=0.0), "tau is left out"),
    "sign": (Dynamics(curved=-1.0), "tau has the wrong sign"),
    "half": (Dynamics(curved=0.5), "tau is halved"),
    "twice": (Dynamics(curved=2.0), "tau is doubled"),
    "diagonal": (Dynamics(cut="diagonal"), "the Gram matrix is cut to its diagonal"),
    "diagonal and flat": (Dynamics(cut="diagonal", curved=0.0), "diagonal, and the curvature term is left out"),
    "free drift": (Dynamics(along=False), "the drift is not projected"),
}
NEAR = {
    "flat": (Dynamics(curved=0.0), "grad ln det G is left out"),
    "sign": (Dynamics(curved=-1.0), "grad ln det G has the wrong sign"),
    "half": (Dynamics(curved=0.5), "grad ln det G is halved"),
    "twice": (Dynamics(curved=2.0), "grad ln det G is doubled"),
    "diagonal": (Dynamics(cut="diagonal"), "cut to its diagonal in g G^-1 zeta/eps"),
    "no Gram": (Dynamics(cut="none"), "the Gram matrix is left out: g zeta/eps"),
}
PLANTED = [
    pytest.param(kind, scheme, says, id=f"{kind}: {name}")
    for kind, planted in (("motion", MOTIONS), ("kept", ON), ("penalised", NEAR))
    for name, (scheme, says) in planted.items()
]


@pytest.mark.sweep
@pytest.mark.parametrize(("kind", "scheme", "says"), PLANTED)
@pytest.mark.parametrize("index", range(2))
def test_mistakes_are_named(kind, scheme, says, index):
    """Each one-line mistake is named on any member."""
    assert says in said(scheme, CLASSES[kind], index)


def test_every_entry_is_planted():
    """No mistake is in the dictionary without a scheme that makes it, nor with two sentences."""
    planted = [says for some in (MOTIONS, ON, NEAR) for _, says in some.values()]
    sentences = [each.sentence for each in DICTIONARY]

    assert not [each for each in sentences if not any(says in each for says in planted)]
    assert len({*sentences}) == len(sentences)


def test_what_no_entry_explains_has_no_sentence():
    """Two mistakes at once, a factor that is in no dictionary, or another noise beside one are not named."""
    unknown = [
        Motion(force_mass=False, place="old", curved=0.0),
        Motion(place="old", curved=1.3),
        Motion(noise_mass=False, variance=1.1),
        Motion(variance=1.1),
    ]

    assert [said(scheme, MECHANICS) for scheme in unknown] == [""] * len(unknown)
    assert said(Dynamics(curved=1.3), KEPT) == ""
    assert said(Dynamics(cut="diagonal", curved=0.5), PENALISED) == ""


def test_the_planted_schemes_are_right_without_their_mistakes():
    """Both ways to write the right line have the rates of the equation, and nothing is said of them."""
    assert [said(scheme, MECHANICS) for scheme in (Motion(), Motion(place="old"))] == ["", ""]
    assert [said(Dynamics(), kind) for kind in (KEPT, PENALISED)] == ["", ""]


def test_a_row_begins_with_the_mistake():
    """A refuted class verdict names the mistake before what was measured; a verified one names none."""
    (row,) = member_rows(Motion(force_mass=False, noise_mass=False), MECHANICS, [Strong()], SEED)

    assert row.verdict is Verdict.REFUTED
    assert row.why.startswith("the mass matrix is left out, M^-1 is meant: a dt + B dw moves the velocity; ")
    assert row.why.endswith("only with a mass matrix that is not the identity")
    assert row.cells["premise"].startswith(row.mistake)


@pytest.mark.long
def test_nothing_is_said_of_right_schemes():
    """No shipped scheme for the forms has a sentence on their members."""
    schemes: list[Any] = [*load_registry(environ={}).things("sdaeverify_schemes").values()]
    schemes += [HalfExplicitEuler(truncation="none"), ConstrainedEuler(direction="new")]
    found = {
        (scheme.label, name, index): text
        for scheme in schemes
        for name, kind in CLASSES.items()
        for index in range(2)
        if isinstance(member := member_of(kind, SEED, index), scheme.forms) and not scheme.refuses(member)
        if (text := member_mistake(scheme, kind, member))
    }

    assert found == {}
