"""Methods of torchsde as schemes; skipped where it is not installed."""

from dataclasses import replace

import numpy as np
import pytest

from bridges.equations import PATHS, H, curved, drawn, shifted
from facade import EulerMaruyama, gbm, noncommuting, spiral, stratonovich
from sdaeverify_bridges.torchsde import ITO, STRATONOVICH, TorchSDEIto, TorchSDEStratonovich

pytest.importorskip("torchsde", reason="needs the extra: pip install .[torchsde]")
METHODS = [*map(TorchSDEIto, ITO), *map(TorchSDEStratonovich, STRATONOVICH)]


def test_a_step_takes_one_thread():
    """PyTorch has one thread while a step is made, and as many as before it afterwards."""
    import torch  # noqa: PLC0415 - it comes with torchsde

    before, seen = torch.get_num_threads(), []
    torch.set_num_threads(2)

    def drift(t, x):
        seen.append(torch.get_num_threads())
        return 0.5 * x

    problem = replace(gbm(), drift=drift)
    seen.clear()  # a problem tries its formulas as it is made
    TorchSDEIto("euler").step(problem, problem.initial(PATHS), 0.5, H, drawn(problem, H, PATHS))
    seen.append(torch.get_num_threads())
    torch.set_num_threads(before)
    assert set(seen[:-1]) == {1}
    assert seen[-1] == 2


def test_milstein_of_scalar_noise_multiplies_by_the_transposed_jacobian():
    """As it is in 0.2.6, the step adds (DB)^T B (dW^2 - h)/2 where DB B belongs: the two differ on a spiral."""
    problem = spiral()
    x, noise = problem.initial(PATHS), drawn(problem, H, PATHS)
    B = problem.diffusion(0.0, np.eye(2))[:, 0]
    euler = EulerMaruyama().step(problem, x, 0.5, H, noise).state

    found = TorchSDEIto("milstein").step(problem, x, 0.5, H, noise).state
    np.testing.assert_allclose(found, euler + B.T @ B @ x * (noise.dW**2 - H) / 2.0, rtol=1e-13)


def test_reversible_method_keeps_its_memory():
    """It adds h (F(x) + F(z))/2 + (B(x) + B(z)) dW/2 with z = x + F(x) h + B(x) dW, which it remembers."""
    problem, scheme = curved(), TorchSDEStratonovich("reversible_heun")
    x, noise = shifted(problem), drawn(problem, H, PATHS)
    F, B = (part.reshape(1, PATHS) for part in stratonovich(problem, 0.5, x))
    z = x + H * F + B * noise.dW
    G, C = (part.reshape(1, PATHS) for part in stratonovich(problem, 0.5 + H, z))

    found = scheme.step(problem, scheme.enter(problem, x, 0.5, H), 0.5, H, noise).state
    expected = x + 0.5 * H * (F + G) + 0.5 * (B + C) * noise.dW
    np.testing.assert_allclose(found, np.concatenate([expected, z, G, C]), rtol=1e-13)
    np.testing.assert_array_equal(scheme.parts(problem, found)["x"], found[:1])


def test_noise_that_a_method_does_not_support_is_refused():
    """Two noises that do not commute are for the general methods."""
    refusing = {scheme.label for scheme in METHODS if scheme.refuses(noncommuting())}

    assert refusing == {
        "torchsde-ito[method=milstein]",
        "torchsde-ito[method=srk]",
        "torchsde-stratonovich[method=milstein]",
    }
