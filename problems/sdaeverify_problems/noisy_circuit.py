"""A ladder of resistors and capacitors with thermal noise, by nodal analysis."""

import numpy as np

from sdaeverify import Array, IndexOneSDAE, hookimpl, in_matrix

from ._arguments import check_not_negative, check_positive
from ._ladder_law import OBSERVABLES, Ladder, truths

SOURCE = "Winkler 2003: circuits of index 1 with noise in parallel to capacitances; Nyquist 1928"
# Boltzmann's constant in pF mV^2/K.
BOLTZMANN = 1.380649e-5


@in_matrix({}, schemes=("drift-implicit-milstein",), measures=("drift", "stability", "strong", "weak"))
def noisy_circuit(  # noqa: PLR0913, PLR0917 - one number for each element
    R_1: float = 1.0,
    R_a: float = 0.5,
    R_b: float = 0.5,
    C_1: float = 1.0,
    C_2: float = 1.0,
    U: float = 0.1,
    temperature: float = 300.0,
    horizon: float = 1.0,
) -> IndexOneSDAE:
    """Noisy RC ladder: source U, R_1, node 1 with C_1 to ground, R_a, node 3, R_b, node 2 with C_2 to ground.

    The voltages x = (e_1, e_2) satisfy Kirchhoff's current law with noise; for y, the voltage of node 3, it has no
    noise:

        C_1 de_1 = [(U - e_1)/R_1 - (e_1 - y)/R_a] dt + sqrt(2 kT/R_1) dW_1 - sqrt(2 kT/(R_a + R_b)) dW_2
        C_2 de_2 = (y - e_2)/R_b dt + sqrt(2 kT/(R_a + R_b)) dW_2,        0 = (e_1 - y)/R_a - (y - e_2)/R_b,

    where the resistors in series share one noise source. Under the invariant law e_1 and e_2 are independent, with
    mean U and variances kT/C_1 and kT/C_2. All voltages are 0 at the start.

    Parameters
    ----------
    R_1 : float
        Resistance, unit kOhm, positive as the others.
    R_a : float
        Resistance, unit kOhm.
    R_b : float
        Resistance, unit kOhm.
    C_1 : float
        Capacitance, unit pF, positive.
    C_2 : float
        Capacitance, unit pF, positive.
    U : float
        Voltage of the source, unit mV.
    temperature : float
        Temperature T, unit K, not negative.
    horizon : float
        Final time, unit ns.

    Source
    ------
    Winkler (2003), J. Comput. Appl. Math. 157, 477: index-1 equations of circuits with noise.
    """
    check_positive(R_1=R_1, R_a=R_a, R_b=R_b, C_1=C_1, C_2=C_2)
    check_not_negative(temperature=temperature)
    C, series, kT = np.array([C_1, C_2]), R_a + R_b, BOLTZMANN * temperature
    G = np.array([[1.0 / R_1 + 1.0 / series, -1.0 / series], [-1.0 / series, 1.0 / series]])
    ladder = Ladder(C, G, U, kT)
    currents = np.sqrt(2.0 * kT / np.array([R_1, series])) * np.array([[1.0, -1.0], [0.0, 1.0]])

    def drift(t: float, x: Array, y: Array) -> Array:
        into = np.stack([(U - x[0]) / R_1 - (x[0] - y[0]) / R_a, (y[0] - x[1]) / R_b])
        return np.asarray(into / C[:, None])

    return IndexOneSDAE(
        drift=drift,
        diffusion=lambda t, x, y: (currents / C[:, None])[..., None],
        constraint=lambda t, x, y: (x[:1] - y) / R_a - (y - x[1:]) / R_b,
        start=[0.0, 0.0],
        algebraic=[0.0],
        noise_dim=2,
        horizon=horizon,
        traits=frozenset({"additive-noise"}),
        observables=OBSERVABLES,
        truths=truths(ladder),
        chart=ladder.chart,
        relaxation_time=ladder.relaxation,
        units="voltages in mV, time in ns",
        source=SOURCE,
    )


@hookimpl
def sdaeverify_problems() -> list[object]:
    """Register the problem."""
    return [noisy_circuit]
