"""dx_j = sqrt(1 + x_j^2) o dW_j from 0: x_j(1) = sinh W_j(1). Needs torchsde alone."""

import math

import torch
import torchsde


class Hyperbolic:
    noise_type, sde_type = "diagonal", "stratonovich"

    def f(self, t, y):
        return 0.0 * y

    def g(self, t, y):
        return (1.0 + y * y).sqrt()


bm = torchsde.BrownianInterval(0.0, 1.0, size=(2000, 2), dtype=torch.float64, entropy=1, dt=1 / 128)
W, ts = bm(0.0, 1.0), torch.tensor([0.0, 1.0], dtype=torch.float64)
print("rms error of asinh x at time 1 with 16, 32, 64, 128 steps, torchsde", torchsde.__version__)
for method in ("reversible_heun", "heun"):
    found = [torchsde.sdeint(Hyperbolic(), 0 * W, ts, bm=bm, method=method, dt=1 / n)[-1] for n in (16, 32, 64, 128)]
    errors = [float((torch.asinh(y) - W).square().mean().sqrt()) for y in found]
    print(f"{method:15} {' '.join(f'{e:.5f}' for e in errors)}  order {math.log2(errors[-2] / errors[-1]):.2f}")
