"""One step of an integrator of ``ase.md`` on all paths at once, with the normal variables of the increment."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from ase import Atoms, units
from ase.calculators.calculator import Calculator
from ase.md.langevin import Langevin as ASELangevin
from ase.md.langevinbaoab import LangevinBAOAB
from ase.md.md import MolecularDynamics

from sdaeverify import Array, Langevin
from sdaeverify_bridges.kit import Compiled


class Known(np.random.Generator):
    """Random generator that returns given normal variables in order.

    Parameters
    ----------
    variables : list of ndarray, shape (atoms, 3)
    """

    def __init__(self, variables: list[Array]) -> None:
        super().__init__(np.random.PCG64(0))
        self.variables = iter(variables)

    def standard_normal(self, size: Any = None, *_: Any, **__: Any) -> Any:
        """Return the next array of variables."""
        return next(self.variables)

    def normal(self, *_: Any, **__: Any) -> Any:
        """Return the next array of variables."""
        return next(self.variables)


class Force(Calculator):
    """Force of a problem on atoms along the first axis, one atom for each coordinate of each path.

    Parameters
    ----------
    problem : Langevin
    """

    implemented_properties = ("energy", "forces")

    def __init__(self, problem: Langevin) -> None:
        super().__init__()
        self.problem = problem

    def calculate(self, atoms: Any = None, *_: Any, **__: Any) -> None:
        """Compute the forces; the energy, which no integrator uses, is 0."""
        super().calculate(atoms)
        q = self.atoms.positions[:, 0].reshape(self.problem.noise_dim, -1)
        self.results = {"energy": 0.0, "forces": along(np.broadcast_to(self.problem.force(q), q.shape))}


def langevin_step(integrator: str, problem: Langevin) -> Compiled:
    """Return the step of an integrator for Langevin dynamics."""
    n, gamma = problem.noise_dim, problem.friction
    temperature = problem.strength**2 / (2.0 * gamma) / units.kB
    made: Callable[..., MolecularDynamics]
    if integrator == "Langevin":
        made = partial(ASELangevin, temperature_K=temperature, friction=gamma, fixcm=False)
    else:
        made = partial(LangevinBAOAB, temperature_K=temperature, T_tau=1.0 / gamma)

    def step(x: Array, t: float, h: float, dW: Array, H: Array | None = None) -> Array:
        known = Known([along(dW / np.sqrt(h)), *([] if H is None else [along(np.sqrt(12.0 / h) * H)])])
        q, p = along(x[:n]), along(x[n:])
        atoms = Atoms(numbers=np.ones(len(q), dtype=int), masses=np.ones(len(q)), positions=q, momenta=p)
        atoms.calc = Force(problem)
        made(atoms, h, rng=known).step()
        return np.concatenate([row[:, 0].reshape(n, -1) for row in (atoms.positions, atoms.get_momenta())])

    return step


def along(values: Array) -> Array:
    """Convert an array of shape (n, P) to vectors along the first axis, shape (n P, 3)."""
    vectors = np.zeros((values.size, 3))
    vectors[:, 0] = values.reshape(-1)
    return vectors
