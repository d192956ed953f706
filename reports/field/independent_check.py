"""Checks what the report refutes, with torchsde alone: nothing of sdaeverify is imported.

Strong errors at time 1 on dz = lambda z dt + mu z dW with z = x_1 + i x_2 and on dx = sqrt(1 + x^2) o dW, whose
solutions are known on the same path, and mean errors of the latter; and the variance of the Levy areas that
``BrownianInterval`` draws over a step of length 1, which is 1/4.

    pip install torchsde && python reports/field/independent_check.py
"""

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
    """Return the root mean square error at time 1 for each number of steps."""
    bm = torchsde.BrownianInterval(0.0, 1.0, size=(PATHS, 1), dtype=torch.float64, entropy=1, dt=1.0 / STEPS[-1])
    exact = torch.exp((LAMBDA - 0.5 * MU**2) + MU * bm(0.0, 1.0)[:, 0].to(torch.complex128))
    x, ts = torch.tensor([[1.0, 0.0]], dtype=torch.float64).repeat(PATHS, 1), torch.tensor([0.0, 1.0]).double()
    found = []
    for n in STEPS:
        with torch.no_grad():
            y = torchsde.sdeint(Spiral(calculus), x, ts, bm=bm, method=method, dt=1.0 / n, options=dict(options))[-1]
        found.append(float((torch.complex(y[:, 0], y[:, 1]) - exact).abs().square().mean().sqrt()))
    return found


class Hyperbolic:
    """dx = sqrt(1 + x^2) o dW whose solution from 0 is sinh W."""

    noise_type, sde_type = "diagonal", "stratonovich"

    def f(self, t, y):
        """Return the drift."""
        return torch.zeros_like(y)

    def g(self, t, y):
        """Return the diffusion."""
        return torch.sqrt(1.0 + y * y)


def hyperbolic_errors(options):
    """Return the mean of |arcsinh x - W| at time 1, and that of arcsinh x - W, for each number of steps."""
    bm = torchsde.BrownianInterval(0.0, 1.0, size=(PATHS, 1), dtype=torch.float64, entropy=3, dt=1.0 / STEPS[-1])
    W, x = bm(0.0, 1.0), torch.zeros(PATHS, 1, dtype=torch.float64)
    found, means = [], []
    for n in STEPS:
        ts = torch.tensor([0.0, 1.0]).double()
        with torch.no_grad():
            y = torchsde.sdeint(Hyperbolic(), x, ts, bm=bm, method="milstein", dt=1.0 / n, options=dict(options))[-1]
        found.append(float((torch.asinh(y) - W).abs().mean()))
        means.append(float((torch.asinh(y) - W).mean()))
    return found, means


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
        found = errors(calculus, method, options)
        slope = -np.polyfit(np.log(STEPS), np.log(found), 1)[0]
        print(f"{calculus:13s} {method} {options}: errors {np.round(found, 5).tolist()}, order {slope:.2f}")
    for options in ({}, {"grad_free": True}):
        found, means = hyperbolic_errors(options)
        slope = -np.polyfit(np.log(STEPS), np.log(found), 1)[0]
        last = np.log2(found[-2] / found[-1])
        print(
            f"hyperbolic, stratonovich milstein {options}: errors {np.round(found, 5).tolist()}, order {slope:.2f},"
        )
        print(f"  in the last halving {last:.2f}; mean errors of arcsinh x {np.round(means, 5).tolist()}")
    for approximation in ("davie", "foster"):
        print(f"E A^2 of {approximation}: {{:.4f}} +- {{:.4f}}, exactly 0.25".format(*area_variance(approximation)))
