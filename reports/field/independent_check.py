"""Checks what the report refutes, with torchsde and mici alone: nothing of sdaeverify is imported.

Strong and mean errors at time 1 on dz = lambda z dt + mu z dW with z = x_1 + i x_2 and on
dx_1 = r_1 o dW_1, dx_2 = r_2 arcsinh x_1 dt + r_2 o dW_2 with r_j = sqrt(1 + x_j^2), whose solutions are known on the
same path; the constraint of a point that moves on a circle; and the variance of the Levy areas that
``BrownianInterval`` draws over a step of length 1, which is 1/4.

    pip install torchsde mici && python reports/field/independent_check.py
"""

import mici
import numpy as np
import torch
import torchsde

LAMBDA, MU = complex(-0.5, 2.0), complex(0.4, 0.6)
PATHS, STEPS = 2000, (16, 32, 64, 128, 256)


def matrix(z):
    """Return the matrix of the multiplication by z."""
    return torch.tensor([[z.real, -z.imag], [z.imag, z.real]], dtype=torch.float64)


class Spiral:
    """The equation as torchsde wants it."""

    noise_type = "scalar"

    def __init__(self, calculus):
        self.sde_type = calculus
        self.drift = LAMBDA - 0.5 * MU**2 if calculus == "stratonovich" else LAMBDA

    def f(self, t, y):
        """Return the drift."""
        return y @ matrix(self.drift).T

    def g(self, t, y):
        """Return the diffusion."""
        return (y @ matrix(MU).T).unsqueeze(-1)


def errors(calculus, method, options):
    """Return the root mean square error at time 1 and the size of the mean one for each number of steps."""
    bm = torchsde.BrownianInterval(0.0, 1.0, size=(PATHS, 1), dtype=torch.float64, entropy=1, dt=1.0 / STEPS[-1])
    exact = torch.exp((LAMBDA - 0.5 * MU**2) + MU * bm(0.0, 1.0)[:, 0].to(torch.complex128))
    x = torch.tensor([[1.0, 0.0]], dtype=torch.float64).repeat(PATHS, 1)
    strong, mean = [], []
    for n in STEPS:
        y = solved(Spiral(calculus), x, bm, n, method, options)
        error = torch.complex(y[:, 0], y[:, 1]) - exact
        strong.append(float(error.abs().square().mean().sqrt()))
        mean.append(float(error.mean().abs()))
    return strong, mean


def solved(equation, x, bm, n, method, options):
    """Return the end of n steps."""
    ts = torch.tensor([0.0, 1.0]).double()
    with torch.no_grad():
        return torchsde.sdeint(equation, x, ts, bm=bm, method=method, dt=1.0 / n, options=dict(options))[-1]


class Hyperbolic:
    """dx_1 = r_1 o dW_1, dx_2 = r_2 arcsinh x_1 dt + r_2 o dW_2: arcsinh x_1 = W_1, arcsinh x_2 = int W_1 + W_2."""

    noise_type, sde_type = "diagonal", "stratonovich"

    def f(self, t, y):
        """Return the drift."""
        return torch.stack([0.0 * y[:, 0], self.g(t, y)[:, 1] * torch.asinh(y[:, 0])], dim=1)

    def g(self, t, y):
        """Return the diffusion."""
        return torch.sqrt(1.0 + y * y)


def hyperbolic_errors(options):
    """Return the means of |arcsinh x_j - exact| at time 1, and of arcsinh x_j - exact, for each number of steps."""
    fine = 4 * STEPS[-1]
    bm = torchsde.BrownianInterval(0.0, 1.0, size=(PATHS, 2), dtype=torch.float64, entropy=3, dt=1.0 / fine)
    W = torch.stack([bm(0.0, (k + 1) / fine) for k in range(fine)])
    integral = (W[:-1, :, 0].sum(dim=0) + 0.5 * W[-1, :, 0]) / fine
    exact, x = torch.stack([W[-1, :, 0], integral + W[-1, :, 1]], dim=1), torch.zeros(PATHS, 2, dtype=torch.float64)
    found = [torch.asinh(solved(Hyperbolic(), x, bm, n, "milstein", options)) - exact for n in STEPS]
    return [error.abs().mean(dim=0).tolist() for error in found], [error.mean(dim=0).tolist() for error in found]


def circle_residual(steps, **tolerances):
    """Return the largest | |q|^2 - 1 | on the way of a point that moves freely on the unit circle for a time of 1."""
    system = mici.systems.DenseConstrainedEuclideanMetricSystem(
        neg_log_dens=lambda q: 0.0,
        grad_neg_log_dens=lambda q: 0.0 * q,
        constr=lambda q: np.array([q @ q - 1.0]),
        jacob_constr=lambda q: 2.0 * q[None],
    )
    integrator = mici.integrators.ConstrainedLeapfrogIntegrator(
        system, step_size=1.0 / steps, projection_solver_kwargs=tolerances
    )
    state = mici.states.ChainState(pos=np.array([1.0, 0.0]), mom=np.array([0.0, 1.0]), dir=1)
    found = []
    for _ in range(steps):
        state = integrator.step(state)
        found.append(abs(float(state.pos @ state.pos) - 1.0))
    return max(found)


def orders(found):
    """Return the order of errors over all numbers of steps, and in the last halving."""
    slope = -np.polyfit(np.log(STEPS), np.log(found), 1)[0]
    return f"order {slope:.2f}, {np.log2(found[-2] / found[-1]):.2f} at last"


def area_variance(approximation):
    """Return the mean of A^2 over a step of length 1 with its standard error."""
    bm = torchsde.BrownianInterval(
        0.0, 1.0, size=(400_000, 2), dtype=torch.float64, entropy=2, levy_area_approximation=approximation
    )
    square = bm(0.0, 1.0, return_A=True)[1][:, 0, 1].square()
    return float(square.mean()), float(square.std() / np.sqrt(len(square)))


if __name__ == "__main__":
    for calculus, method, options in (
        ("ito", "milstein", {}),
        ("ito", "milstein", {"grad_free": True}),
        ("stratonovich", "milstein", {}),
        ("stratonovich", "milstein", {"grad_free": True}),
        ("stratonovich", "heun", {}),
    ):
        strong, mean = errors(calculus, method, options)
        print(f"spiral, {calculus} {method} {options}: errors {np.round(strong, 5).tolist()}, {orders(strong)}")
        print(f"  mean errors {np.round(mean, 5).tolist()}")
    for options in ({}, {"grad_free": True}):
        strong, means = hyperbolic_errors(options)
        for j in (0, 1):
            found, mean = ([row[j] for row in rows] for rows in (strong, means))
            print(f"hyperbolic x_{j + 1}, stratonovich milstein {options}:")
            print(f"  errors {np.round(found, 5).tolist()}, {orders(found)}")
            # Without the option they are sampling errors.
            print(f"  mean errors {np.round(mean, 5).tolist()}{', ' + orders(mean) if options else ''}")
    for steps in (8, 16, 32):
        usual, sharp = circle_residual(steps), circle_residual(steps, constraint_tol=1e-14, position_tol=1e-14)
        print(f"circle, mici, {steps} steps: residual {usual:.1e}, {sharp:.1e} with tolerances of 1e-14")
    for approximation in ("davie", "foster"):
        print(f"E A^2 of {approximation}: {{:.4f}} +- {{:.4f}}, exactly 0.25".format(*area_variance(approximation)))
