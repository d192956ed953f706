"""E A^2 and E[(A - (H_1 W_2 - W_1 H_2))^2 | H] over a step of length 1: drawn, mended, and from fine paths."""

import math

import torch
import torchsde
from torchsde._brownian import brownian_interval

P, STEPS = 200_000, 100
torch.manual_seed(1)


def told(name, W, H, A):
    rest = (A - H[:, 0] * W[:, 1] + W[:, 0] * H[:, 1]).square()
    squares = torch.stack([torch.ones_like(rest), H.square().sum(1)], 1)
    a, b = torch.linalg.lstsq(squares, rest.unsqueeze(1)).solution[:, 0].tolist()
    error = A.square().std() / math.sqrt(P)
    print(f"{name:15} E A^2 = {A.square().mean():.4f} +- {error:.4f}, E[rest^2 | H] = {a:.3f} + {b:.3f} |H|^2")


def drawn(approximation):
    bm = torchsde.BrownianInterval(
        0.0, 1.0, size=(P, 2), dtype=torch.float64, entropy=2, levy_area_approximation=approximation
    )
    W, U, A = bm(0.0, 1.0, return_U=True, return_A=True)
    return W, U - 0.5 * W, A[:, 0, 1]


def fine():
    W, U, A = torch.zeros(P, 2), torch.zeros(P, 2), torch.zeros(P)
    for _ in range(STEPS):
        dW = torch.randn(P, 2) / math.sqrt(STEPS)
        U += (W + 0.5 * dW) / STEPS
        A += 0.5 * (W[:, 0] * dW[:, 1] - W[:, 1] * dW[:, 0])
        W += dW
    return W, U - 0.5 * W, A


def mended(W, H, h, approximation, get_noise):
    A = H.unsqueeze(-1) * W.unsqueeze(-2) - W.unsqueeze(-1) * H.unsqueeze(-2)
    noise, squares = get_noise(), H.square()
    variance = (
        h**2 / 24
        if approximation == "davie"
        else 0.1 * h * (0.25 * h + squares.unsqueeze(-1) + squares.unsqueeze(-2))
    )
    return A + torch.as_tensor(variance).sqrt() * (noise - noise.transpose(-1, -2))


print("torchsde", torchsde.__version__, "with", P, "draws; exactly E A^2 = 0.25")
told("fine paths", *fine())
for name in ("davie", "foster"):
    told(name, *drawn(name))
brownian_interval._davie_foster_approximation = mended
for name in ("davie", "foster"):
    told(f"{name}, mended", *drawn(name))
