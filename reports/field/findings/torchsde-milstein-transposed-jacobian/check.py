"""dx = J x dW with a rotation J: x(1) = exp(J W) x(0), times sqrt(e) in Ito's calculus. Needs torchsde alone."""

import math

import torch
import torchsde
from torchsde._core import base_sde, misc

J = torch.tensor([[0.0, -1.0], [1.0, 0.0]], dtype=torch.float64)


class Rotation:
    noise_type = "scalar"

    def f(self, t, y):
        return 0.0 * y

    def g(self, t, y):
        return (y @ J.T).unsqueeze(-1)


def mended(self, t, y, v1, v2):
    with torch.enable_grad():
        y = y.detach().requires_grad_(True)
        g = self.g(t, y).squeeze(-1)
        (gdg,) = misc.jvp(outputs=g, inputs=y, grad_inputs=g * v2, allow_unused=True)
    return self.prod(g.unsqueeze(-1), v1), gdg


def table(name, options):
    sde, bm = Rotation(), torchsde.BrownianInterval(0.0, 1.0, size=(4000, 1), dtype=J.dtype, entropy=1, dt=1 / 256)
    W, ts = bm(0.0, 1.0)[:, 0], torch.tensor([0.0, 1.0], dtype=J.dtype)
    x = torch.tensor([[1.0, 0.0]], dtype=J.dtype).repeat(len(W), 1)
    for sde.sde_type, growth in (("ito", 0.5), ("stratonovich", 0.0)):
        exact, errors = math.exp(growth) * torch.stack([W.cos(), W.sin()], 1), []
        for n in (16, 32, 64, 128, 256):
            y = torchsde.sdeint(sde, x, ts, bm=bm, method="milstein", dt=1 / n, options=dict(options))[-1]
            errors.append(float((y - exact).square().sum(1).mean().sqrt()))
        order = math.log2(errors[-2] / errors[-1])
        print(f"{sde.sde_type:12} {name:15} {' '.join(f'{e:.4f}' for e in errors)}  order {order:.2f}")


print("rms error at time 1 with 16, 32, 64, 128, 256 steps, torchsde", torchsde.__version__)
table("default", {})
table("grad_free=True", {"grad_free": True})
base_sde.ForwardSDE.g_prod_and_gdg_prod_default = mended
table("mended", {})
