"""Strategies of hypothesis for random problems of every form, for property tests of schemes and for hunts.

::

    from hypothesis import given
    from sdaeverify_hunt.strategies import sdes

    @given(sdes(kinds=("diagonal",), groups=("dissipative",)))
    def test_my_scheme_is_finite(example):
        problem = example.build()

An `Example` is a record of numbers, among them those of the terms a cos(k.z + w t + p) of each coefficient. Its
properties hold by construction: diagonal noise is diagonal, the constraint of an equation of index 1 has
|G_y| <= 1/2, and the gradient of a holonomic constraint vanishes nowhere. Its ``source`` is a plugin file whose
problem ``counterexample(horizon)`` is the one that ``build()`` returns.

The strategies require hypothesis: ``pip install 'sdaeverify[hunt]'``.
"""

from importlib.util import find_spec

from sdaeverify.errors import MissingLibraryError

if find_spec("hypothesis") is None:
    raise MissingLibraryError(
        "examples are drawn by hypothesis, which is not installed: pip install 'sdaeverify[hunt]'"
    )

from .delay import DELAY_KINDS, INDEX_ONE_KINDS, DelayExample, IndexOneExample, delays, index_ones
from .draws import GROUPS
from .example import Example
from .forms import EXAMPLES, STATIONARY, Drawing
from .gradient import GradientExample, gradients
from .holonomic import HolonomicExample, holonomics
from .langevin import LangevinExample, langevins
from .overdamped import OverdampedExample, overdamped
from .sde import KINDS, SDEExample, sdes
from .shipped import ShippedExample, shipped
from .terms import Field, Term

__all__ = [
    "DELAY_KINDS",
    "EXAMPLES",
    "GROUPS",
    "INDEX_ONE_KINDS",
    "KINDS",
    "STATIONARY",
    "DelayExample",
    "Drawing",
    "Example",
    "Field",
    "GradientExample",
    "HolonomicExample",
    "IndexOneExample",
    "LangevinExample",
    "OverdampedExample",
    "SDEExample",
    "ShippedExample",
    "Term",
    "delays",
    "gradients",
    "holonomics",
    "index_ones",
    "langevins",
    "overdamped",
    "sdes",
    "shipped",
]
