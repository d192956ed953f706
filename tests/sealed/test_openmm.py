"""OpenMM's LangevinMiddleIntegrator as a sealed solver; skipped where OpenMM is not installed."""

from dataclasses import replace

import numpy as np
import pytest

from sdaeverify_sealed.openmm import ENERGIES, OpenMM, energy_of
from sdaeverify_sealed.sample import Budget
from sealed.solving import rows, spec

STEP, PATHS, WELLS = 0.5, 2**15, "double-well-langevin"


def harmonic():
    return spec("harmonic-langevin").build()


def test_energies_are_found_from_forces():
    """The force of a well, of a pendulum and of two wells has its energy as an expression; others are refused."""
    well = harmonic()
    double = replace(well, force=lambda q: q - q**3, truths=())

    assert energy_of(well)[0].startswith("(2.25000000000")
    assert energy_of(well)[0].endswith(")*(x^2/2)")
    assert energy_of(spec("angle-pendulum").build())[0].endswith("*(-cos(x))")
    assert [energy in energy_of(double)[0] for energy in ENERGIES] == [True, True, False, False]
    assert energy_of(spec(WELLS).build())[0].endswith("*(log(cosh(2*x)))")
    assert "no potential" in energy_of(replace(well, force=lambda q: -np.tanh(q), truths=()))[1]


@pytest.mark.long
def test_configurations_are_verified_and_velocities_are_those_of_half_steps():
    """As documented, q^2 and the temperature of the returned velocities are right; at the time of q it is too low.

    Its bias is -kT h^2 omega^2/4, which the interval of what is found has to contain.
    """
    pytest.importorskip("openmm", reason="needs the extra: pip install .[openmm]")
    returned, on_step = OpenMM(), OpenMM(on_step=True)
    budget = Budget(paths=PATHS, looks=1, steps=(2, 3, 4))
    found, wrong = (
        {
            row.finding.quantity: row.finding
            for row in rows([made], "harmonic-langevin", budget)[0]
            if row.measure == "invariant"
        }
        for made in (returned, on_step)
    )
    problem = harmonic()
    kT, omega2 = problem.strength**2 / (2.0 * problem.friction), problem.force(-np.ones((1, 1)))[0, 0]
    assert found["q^2"].verdict.value == found["p^2"].verdict.value == wrong["q^2"].verdict.value == "verified"
    assert wrong["p^2"].verdict.value == "refuted"
    assert wrong["p^2"].low < -0.25 * kT * STEP**2 * omega2 < wrong["p^2"].high < 0.0


@pytest.mark.long
def test_temperature_at_the_time_of_the_positions_is_refuted_in_two_wells():
    """The temperature of the returned velocities is right where no law is normal; at the time of q it is too low."""
    pytest.importorskip("openmm", reason="needs the extra: pip install .[openmm]")
    budget = Budget(paths=PATHS, looks=1, steps=(1, 2, 4))
    found = [
        {(row.measure, row.finding.quantity): row.finding.verdict.value for row in rows([made], WELLS, budget)[0]}
        for made in (OpenMM(), OpenMM(on_step=True))
    ]
    assert [each["invariant", "p^2"] for each in found] == ["verified", "refuted"]


def test_positions_are_those_of_baoab_from_the_begin():
    """Without noise, one step from q and p moves q as BAOAB does, and leaves its velocity if that is asked for."""
    pytest.importorskip("openmm", reason="needs the extra: pip install .[openmm]")
    cold = replace(harmonic(), strength=1e-12, truths=())
    q, p = OpenMM(on_step=True).run(cold, 0.25, 0.25, 3, 1)
    (q_0,), (p_0,) = cold.initial(1)
    half = p_0 + 0.125 * cold.force(np.full((1, 1), q_0))[0, 0]
    middle = q_0 + 0.125 * half
    after = np.exp(-0.25 * cold.friction) * half
    end = middle + 0.125 * after

    np.testing.assert_allclose(q, end, rtol=1e-9)
    np.testing.assert_allclose(p, after + 0.125 * cold.force(np.full((1, 1), end))[0, 0], rtol=1e-9)


def test_a_seed_repeats_a_run():
    """The same seed gives the same bits on the platform Reference, another one does not."""
    pytest.importorskip("openmm", reason="needs the extra: pip install .[openmm]")
    first, again, other = (OpenMM().run(harmonic(), 0.5, 2.0, 10, seed) for seed in (3, 3, 4))

    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
