"""Strategies and examples by form."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from hypothesis import strategies as st

from . import delay, gradient, holonomic, langevin, overdamped, sde, shipped
from .example import Example


class Drawing(NamedTuple):
    """Strategy of a form with its kinds and classes.

    Attributes
    ----------
    strategy : callable, (kinds, groups, largest) -> SearchStrategy
    kinds, groups : tuple of str
        All kinds of noise or delay, and all classes of coefficients.
    traits : mapping of str to tuple of str
        Traits that a kind has by construction.
    """

    strategy: Callable[..., st.SearchStrategy[Any]]
    kinds: tuple[str, ...]
    groups: tuple[str, ...]
    traits: Mapping[str, tuple[str, ...]]


# Drawings by the name of the form.
EXAMPLES: dict[str, Drawing] = {
    sde.SDEExample.form: Drawing(sde.sdes, sde.KINDS, sde.SUITABLE, sde.TRAITS | {sde.SCALAR: ("scalar-noise",)}),
    langevin.LangevinExample.form: Drawing(langevin.langevins, langevin.KINDS, langevin.SUITABLE, {}),
    delay.IndexOneExample.form: Drawing(delay.index_ones, delay.INDEX_ONE_KINDS, delay.SUITABLE, delay.TRAITS),
    delay.DelayExample.form: Drawing(delay.delays, delay.DELAY_KINDS, delay.SUITABLE, delay.TRAITS),
    holonomic.HolonomicExample.form: Drawing(
        holonomic.holonomics, holonomic.KINDS, holonomic.SUITABLE, holonomic.TRAITS
    ),
    overdamped.OverdampedExample.form: Drawing(overdamped.overdamped, overdamped.KINDS, overdamped.SUITABLE, {}),
}
# Drawings with known invariant laws, for bounds of stationary biases, which other examples cannot refute.
STATIONARY: dict[str, Drawing] = {
    gradient.GRADIENT: Drawing(gradient.gradients, (gradient.GRADIENT,), gradient.GROUPS, gradient.TRAITS)
}
# Classes of examples by the name of their form, including registered problems with other numbers.
CLASSES: dict[str, type[Example]] = {
    each.form: each
    for each in (
        sde.SDEExample,
        langevin.LangevinExample,
        delay.IndexOneExample,
        delay.DelayExample,
        holonomic.HolonomicExample,
        overdamped.OverdampedExample,
        shipped.ShippedExample,
    )
} | {gradient.GRADIENT: gradient.GradientExample}
