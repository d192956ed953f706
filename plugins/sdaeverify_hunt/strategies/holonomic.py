"""Strategies for mechanics with holonomic constraints: quartic ellipsoids, planar sections, coupled masses."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from hypothesis import strategies as st

from .draws import DISSIPATIVE, LIPSCHITZ, SMALL_NOISE, choices, fields, noise_of_group, starts, unit
from .example import Example, matrix_text, vector_text
from .terms import FOURTH, LINE, SQUARE, Columns, Field, Term, indexed, scaled, scaled_columns, sum_text

POSITION, VELOCITY = KINDS = ("noise of positions", "noise of velocities")
# Noise that does not depend on velocities keeps this property under projection.
TRAITS = {POSITION: ("vanishing-milstein-term",)}
SUITABLE = (LIPSCHITZ, DISSIPATIVE, SMALL_NOISE)
AXES, FOURTHS, COUPLINGS, MASSES = (1.0, 0.5, 1.5), (0.0, 0.25), (0.0, 0.25, -0.25), (1.0, 2.0, 0.75)
# Distance from a surface up to which its bounds hold.
EPS = 0.01
# First component of a start, nonzero so that the surface avoids the origin, where its normal vanishes.
FIRST = (1.0, -1.5, 0.75)
SURFACE = """start = np.array({start})

def surface({state}):
    return rows({state}, {values})

def constraint({state}):
    return surface({state}) - surface(start[:, None])
"""
TANGENT = """normals = surface(start[:, None] + 1e-30j * np.eye(len(start))).imag / 1e-30
pushed = np.array({velocity})
velocity = pushed - normals.T @ np.linalg.solve(normals @ normals.T, normals @ pushed)
"""


def surfaces(n: int, *, planes: bool) -> st.SearchStrategy[tuple[Field, ...]]:
    """Draw constraints on n components with a Gram matrix bounded below: an ellipsoid, possibly with a plane.

    On sum_i s_i x_i^2 + q x_1^4 = c the gradient vanishes nowhere for s_i > 0, q >= 0 and c > 0. Neither does its
    part along a plane x_n = c_n on which the ellipsoid has a point with x_1 != 0.

    Parameters
    ----------
    n : int
        Number of components, at least 2.
    planes : bool
        Whether a plane may be added, for n of at least 3.
    """

    def of(axes: tuple[float, ...], fourth: float, plane: bool) -> tuple[Field, ...]:
        square = tuple(Term(s, unit(row, n), shape=SQUARE) for row, s in enumerate(axes))
        ellipsoid = (*square, Term(fourth, unit(0, n), shape=FOURTH))
        return (ellipsoid, (Term(1.0, unit(n - 1, n), shape=LINE),)) if plane else (ellipsoid,)

    plane = st.booleans() if planes and n >= 3 else st.just(value=False)
    return st.builds(of, st.tuples(*[st.sampled_from(AXES)] * n), st.sampled_from(FOURTHS), plane)


def on_surface(n: int) -> st.SearchStrategy[tuple[float, ...]]:
    """Draw initial states of n components away from the origin."""
    return st.builds(lambda first, rest: (first, *rest), st.sampled_from(FIRST), starts(n - 1))


def largest_constant(surface: tuple[Field, ...], start: tuple[float, ...], mass: list[list[float]]) -> float | None:
    """Return C_g of Lindner & Stroot (2017), (2.7), of an ellipsoid; None if D^2 g is unbounded or m > 1.

    On sum_i s_i x_i^2 = c, 4 c s_min <= |grad g|^2 <= 4 c s_max, and at the distance eps the gradient differs by at
    most eps |D^2 g| = 2 eps s_max. G_M and |M^{-1} grad g| follow from the eigenvalues of M.

    Parameters
    ----------
    surface : tuple of Field
        Constraint g, up to constants.
    start : tuple of float
        Point of the surface.
    mass : list of lists of float
        Mass matrix M.
    """
    if len(surface) > 1 or any(term.size and term.shape != SQUARE for term in surface[0]):
        return None
    axes = np.array([term.size for term in surface[0] if term.size])
    c, second = float(axes @ np.square(start)), 2.0 * axes.max()
    low = 2.0 * np.sqrt(c * axes.min()) - EPS * second
    high = 2.0 * np.sqrt(c * axes.max()) + EPS * second
    light, heavy = np.linalg.eigvalsh(mass)[[0, -1]]
    # Rounded upwards, because an example is written with few digits.
    return float(np.ceil(100.0 * max(high**2 / light, heavy / low**2, high / light, second, 1.0)) / 100.0)


def surface_text(state: str, start: tuple[float, ...], surface: tuple[Field, ...]) -> str:
    """Return the definitions of a start and of the constraint that vanishes there.

    Parameters
    ----------
    state : str
        Name of the argument of the constraint.
    start : tuple of float
    surface : tuple of Field
        Functions whose level sets through the start are the constraints.
    """
    values = ", ".join(sum_text(field, indexed(state, len(start))) for field in surface)
    return SURFACE.format(state=state, start=list(start), values=values)


@dataclass(frozen=True)
class HolonomicExample(Example):
    """Constrained mechanics M dv = a dt + B dw + grad g dmu, dr = v dt, g(r) = 0.

    Attributes
    ----------
    force : tuple of Field
        a, of t, r and v.
    columns : tuple of tuples of Field
        Columns of B.
    surface : tuple of Field
        g, of r, up to constants.
    velocity : tuple of float
        v at time 0 before it is projected onto the tangent space.
    masses : tuple of float
        The diagonal of M.
    coupling : float
        Off-diagonal entry of M in the first row.
    """

    form: ClassVar[str] = "HolonomicSDAE"
    state: ClassVar[str] = "r"
    traits_of_kinds: ClassVar[Mapping[str, tuple[str, ...]]] = TRAITS
    sums: ClassVar[tuple[str, ...]] = ("force", "columns")
    begun_by: ClassVar[Mapping[str, str]] = MappingProxyType({"r": "start", "v": "velocity"})

    force: tuple[Field, ...]
    columns: Columns
    surface: tuple[Field, ...]
    velocity: tuple[float, ...]
    masses: tuple[float, ...]
    coupling: float

    @property
    def fields(self) -> tuple[Field, ...]:
        """Coefficients a and B."""
        return (*self.force, *(field for column in self.columns for field in column))

    @property
    def mass(self) -> list[list[float]]:
        """Mass matrix M."""
        n = self.dimension
        rows = [[self.masses[row] * float(row == column) for column in range(n)] for row in range(n)]
        rows[0][1] = rows[1][0] = self.coupling
        return rows

    def definitions(self) -> Iterator[str]:
        """Yield the definitions of a, B, g and the start."""
        names = [*indexed("r", self.dimension), *indexed("v", self.dimension)]
        yield vector_text("force", "t, r, v", self.force, names)
        yield matrix_text("diffusion", "t, r, v", self.columns, names)
        yield surface_text("r", self.start, self.surface)
        yield TANGENT.format(velocity=list(self.velocity))

    def arguments(self) -> Iterator[str]:
        """Yield coefficients, constraint, start and mass."""
        yield from ("force=force", "diffusion=diffusion", "constraint=constraint", "position=start")
        yield from ("velocity=velocity", f"noise_dim={len(self.columns)}")
        if set(self.masses) != {1.0} or self.coupling:
            yield f"mass=np.array({self.mass})"
        if (bound := largest_constant(self.surface, self.start, self.mass)) is not None:
            yield f"constraint_bound={bound}"

    def doubled(self) -> "HolonomicExample":
        """Return the example with 2 a and 2 B."""
        return replace(self, force=scaled(self.force, 2.0), columns=scaled_columns(self.columns, 2.0))


@st.composite
def holonomics(
    draw: Any, kinds: tuple[str, ...] = KINDS, groups: tuple[str, ...] = SUITABLE, largest: int = 3
) -> HolonomicExample:
    """Draw constrained mechanics.

    Parameters
    ----------
    draw : callable
        Draw function of hypothesis.
    kinds, groups : tuple of str
        Kinds and classes to draw from.
    largest : int
        Largest number of components of the state; the number is at least 2.
    """
    kind, group, n = draw(choices(kinds, groups, largest, least=2))
    force = draw(fields(n, 2 * n))
    if group == DISSIPATIVE:
        force = tuple((*field, Term(-1.0, unit(n + row, 2 * n), shape=LINE)) for row, field in enumerate(force))
    one = fields(n, n if kind == POSITION else 2 * n)
    columns = noise_of_group(draw(st.integers(1, 2).flatmap(lambda l: st.tuples(*[one] * l))), group)
    surface, start = draw(surfaces(n, planes=True)), draw(on_surface(n))
    masses, coupling = draw(st.tuples(*[st.sampled_from(MASSES)] * n)), draw(st.sampled_from(COUPLINGS))
    return HolonomicExample(kind, group, 1.0, start, force, columns, surface, draw(starts(n)), masses, coupling)
