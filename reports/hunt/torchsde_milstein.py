"""torchsde's milstein on the counterexample that a hunt found and shrunk, without the verifier.

    sdaeverify hunt 'torchsde-ito[method=milstein]' --measure strong --minutes 3

found after 8 examples, and shrank to two components and one motion,

    dx_1 = B(t, x) dW,  B = 0.5 cos 1 - cos(t - x_1 + 2 x_2) + cos(-2.5 - 1.5 t - x_1 - 1.5 x_2),   dx_2 = dt/2.

The documentation claims strong order 1 for scalar noise. Milstein's scheme by hand has it on the same paths.
Needs torchsde alone: `python reports/hunt/torchsde_milstein.py`
"""

from itertools import pairwise

import numpy as np
import torch
import torchsde

PATHS, FINE, LEVELS = 1000, 2**12, (16, 32, 64, 128, 256)
START = np.array([1.5, 0.0])


def phases(t, x):
    """Return the arguments of both cosines that move, x of shape (P, 2)."""
    return t - x[:, 0] + 2.0 * x[:, 1], -2.5 - 1.5 * t - x[:, 0] - 1.5 * x[:, 1]


class Equation(torch.nn.Module):
    """The equation as torchsde takes it."""

    noise_type, sde_type = "scalar", "ito"

    def f(self, t, y):
        """Return the drift."""
        return torch.stack([0.0 * y[:, 0], 0.5 + 0.0 * y[:, 0]], dim=1)

    def g(self, t, y):
        """Return the diffusion, shape (P, 2, 1)."""
        first, second = phases(t, y)
        B = 0.5 * np.cos(1.0) - torch.cos(first) + torch.cos(second)
        return torch.stack([B, 0.0 * B], dim=1)[..., None]


def milstein(increments, h):
    """Return the ends of Milstein's scheme by hand: x_1 + B dW + B dB/dx_1 (dW^2 - h)/2."""
    x = np.tile(START, (increments.shape[1], 1))
    for n, dW in enumerate(increments):
        first, second = phases(n * h, x)
        B = 0.5 * np.cos(1.0) - np.cos(first) + np.cos(second)
        slope = -np.sin(first) + np.sin(second)
        x = x + np.stack([B * dW + 0.5 * slope * B * (dW**2 - h), 0.5 * h + 0.0 * B], axis=1)
    return x


def main():
    """Print the errors at the end, and the slopes."""
    torch.manual_seed(1)
    noise = torchsde.BrownianInterval(0.0, 1.0, size=(PATHS, 1), dtype=torch.float64, dt=1.0 / FINE, entropy=1)
    edges = torch.linspace(0.0, 1.0, FINE + 1, dtype=torch.float64)
    dW = np.array([noise(a, b).numpy()[:, 0] for a, b in pairwise(edges)])
    exact, start = milstein(dW, 1.0 / FINE), torch.tensor(np.tile(START, (PATHS, 1)))
    times = torch.tensor([0.0, 1.0], dtype=torch.float64)
    errors = {"torchsde milstein": [], "milstein by hand": []}
    for n in LEVELS:
        with torch.no_grad():
            end = torchsde.sdeint(Equation(), start, times, bm=noise, dt=1.0 / n, method="milstein")[-1].numpy()
        by_hand = milstein(dW.reshape(n, FINE // n, PATHS).sum(axis=1), 1.0 / n)
        for name, found in zip(errors, (end, by_hand), strict=True):
            errors[name].append(float(np.sqrt(np.mean((found - exact) ** 2 @ [1.0, 1.0]))))
    for name, rms in errors.items():
        slope = -np.polyfit(np.log2(LEVELS), np.log2(rms), 1)[0]
        print(f"{name}: rms {' '.join(f'{each:.4f}' for each in rms)} at {LEVELS} steps, strong order {slope:.2f}")


if __name__ == "__main__":
    main()
