"""Constrained Langevin dynamics with potential, friction and noise, Lindner & Stroot (2017), section 5.2."""

from collections.abc import Callable
from typing import Any

import numpy as np

from sdaeverify import Array, HolonomicSDAE, ProblemError

from .._arguments import function, in_one_line, instance
from ._bath import Bath

SOURCE = "Lindner & Stroot 2017, section 5.2"


@in_one_line
def constrained_langevin(gradient: Callable[[Array], Array], bath: Bath, **mechanics: Any) -> HolonomicSDAE:
    """Return dr = v dt, M dv = ( -grad V(r) - gamma(r) v ) dt + sigma(r) dw + grad g(r) dmu, g(r) = 0.

    Parameters
    ----------
    gradient : callable, r -> ndarray, shape (n, P) or (n, 1)
        grad V.
    bath : Bath
    **mechanics
        Other fields of `HolonomicSDAE`: constraint, mass matrix M, initial data and truths.

    Returns
    -------
    HolonomicSDAE

    Raises
    ------
    ParameterError, ProblemError
        If the bath is invalid, the position is missing, or grad V has an unexpected shape.

    Source
    ------
    Lindner & Stroot (2017), section 5.2, with r = q, v = M^{-1} p, g = xi - z and mu = lambda.
    """
    function("gradient", gradient)
    instance("bath", bath, Bath)
    if "position" not in mechanics:
        raise ProblemError("constrained Langevin dynamics need the position they start from")
    r = np.asarray(mechanics["position"], dtype=float)[:, None]
    if np.shape(gradient(r)) != r.shape:
        raise ProblemError(f"grad V returned shape {np.shape(gradient(r))} for positions of shape {r.shape}")
    bath.check(r)
    sigma, trait = bath.sigma(r), "additive-noise" if bath.constant else "vanishing-milstein-term"
    return HolonomicSDAE(
        force=lambda t, r, v: -gradient(r) - bath.drag(r, v),
        diffusion=lambda t, r, v: sigma if bath.constant else bath.sigma(r),
        noise_dim=sigma.shape[1],
        traits=frozenset({trait}),
        **{"source": SOURCE, **mechanics},
    )
