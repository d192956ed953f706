"""Facts of index-1 equations with or without a delay that claims ask for."""

from ..traits import Trait

INDEX_ONE: tuple[Trait, ...] = (
    Trait(
        "algebraic",
        "Its constraint determines algebraic components that a step solves for: index 1 (set by the form itself).",
    ),
    Trait(
        "dissipative",
        "It satisfies the sufficient condition (4.1) of Qu, Huang & Liu (2010) for mean-square stability, as it is "
        "or with y eliminated (set by the form).",
    ),
    Trait("delayed-noise", "The diffusion of a delay equation depends on time and the delayed state alone."),
)
