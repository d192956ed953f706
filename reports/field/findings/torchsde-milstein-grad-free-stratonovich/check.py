"""dx = sqrt(1 + x^2) o dW from 0: x(1) = sinh W(1). Needs torchsde alone."""

import math

import torch
import torchsde
from torchsde._core.methods import milstein


class Hyperbolic:
    noise_type, sde_type = "diagonal", "stratonovich"

    def f(self, t, y):
        return 0.0 * y

    def g(self, t, y):
        return (1.0 + y * y).sqrt()


def mended(self, t0, t1, y0, extra0):
    I_k = self.bm(t0, t1)
    f, g = self.sde.f_and_g(t0, y0)
    g_prime = self.sde.g(t0, y0 + g * I_k)
    return y0 + f * (t1 - t0) + self.sde.prod(g, I_k) + 0.5 * self.sde.prod(g_prime - g, I_k), ()


def table(name, options):
    bm = torchsde.BrownianInterval(0.0, 1.0, size=(10000, 1), dtype=torch.float64, entropy=1, dt=1 / 128)
    W, ts = bm(0.0, 1.0), torch.tensor([0.0, 1.0], dtype=torch.float64)
    found = []
    for n in (16, 32, 64, 128):
        y = torchsde.sdeint(Hyperbolic(), 0 * W, ts, bm=bm, method="milstein", dt=1 / n, options=dict(options))[-1]
        found.append(torch.asinh(y) - W)
    rms, mean = [e.square().mean().sqrt() for e in found], [e.mean() for e in found]
    print(f"{name:15} rms  {line(rms)}  order {math.log2(rms[-2] / rms[-1]):.2f}")
    print(f"{name:15} mean {line(mean)}")


def line(errors):
    return " ".join(f"{float(e):8.5f}" for e in errors)


print("error of asinh x at time 1 with 16, 32, 64, 128 steps, torchsde", torchsde.__version__)
table("default", {})
table("grad_free=True", {"grad_free": True})
milstein.MilsteinStratonovich.step = mended
table("mended", {"grad_free": True})
