"""Methods of torchsde as schemes; skipped where it is not installed."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from bridges.equations import curved, drawn
from facade import SRA1, EulerMaruyama, Heun, Milstein, angle_pendulum, gbm, noncommuting, ou, spiral, stratonovich
from sdaeverify import SDE, Increment, ParameterError
from sdaeverify_bridges.torchsde import ITO, STRATONOVICH, TorchSDEIto, TorchSDEStratonovich

H, PATHS = 0.125, 7
METHODS = [*map(TorchSDEIto, ITO), *map(TorchSDEStratonovich, STRATONOVICH)]


@pytest.fixture(scope="module", autouse=True)
def library():
    """Skip where torchsde is not installed."""
    return pytest.importorskip("torchsde", reason="torchsde is not installed; pip install '.[torchsde]'")


@pytest.mark.parametrize(
    ("theirs", "ours", "family"),
    [
        (TorchSDEIto("euler"), EulerMaruyama(), gbm),
        (TorchSDEIto("euler"), EulerMaruyama(), noncommuting),
        (TorchSDEIto("milstein"), Milstein(), curved),
        (TorchSDEIto("srk"), SRA1(), ou),
        (TorchSDEIto("srk"), SRA1(), angle_pendulum),
        (TorchSDEStratonovich("heun"), Heun(), curved),
        (TorchSDEStratonovich("heun"), Heun(), noncommuting),
        (TorchSDEStratonovich("heun"), Heun(), spiral),
    ],
)
def test_our_schemes_agree_to_rounding(theirs, ours, family):
    """On the same noise torchsde makes the step that ours makes, whoever takes the derivatives."""
    problem = family().view(SDE)
    x, noise = problem.initial(PATHS) + 0.1 * np.arange(PATHS), drawn(problem, H, PATHS)

    found, expected = (scheme.step(problem, x, 0.5, H, noise).state for scheme in (theirs, ours))
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=4.0 * np.finfo(float).eps * np.abs(expected).max())


def test_a_step_takes_one_thread(library):
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
    x, noise = problem.initial(PATHS) + 0.1 * np.arange(PATHS), drawn(problem, H, PATHS)
    F, B = (part.reshape(1, PATHS) for part in stratonovich(problem, 0.5, x))
    z = x + H * F + B * noise.dW
    G, C = (part.reshape(1, PATHS) for part in stratonovich(problem, 0.5 + H, z))

    found = scheme.step(problem, scheme.enter(problem, x, 0.5, H), 0.5, H, noise).state
    expected = x + 0.5 * H * (F + G) + 0.5 * (B + C) * noise.dW
    np.testing.assert_allclose(found, np.concatenate([expected, z, G, C]), rtol=1e-13)
    np.testing.assert_array_equal(scheme.parts(problem, found)["x"], found[:1])


@pytest.mark.parametrize("scheme", METHODS, ids=lambda scheme: scheme.label)
def test_paths_do_not_see_each_other(scheme):
    """A path of a batch is the same to the last bit as that path alone."""
    problem = ou()
    x, noise = problem.initial(PATHS) + 0.1 * np.arange(PATHS), drawn(problem, H, PATHS)
    state = scheme.enter(problem, x, 0.5, H)
    all_of_them = scheme.step(problem, state, 0.5, H, noise).state

    alone = Increment(noise.dW[:, 4:5], noise.H[:, 4:5])
    np.testing.assert_array_equal(scheme.step(problem, state[:, 4:5], 0.5, H, alone).state, all_of_them[:, 4:5])


def test_noise_that_a_method_does_not_support_is_refused():
    """Two noises that do not commute are for the general methods."""
    refusing = {scheme.label for scheme in METHODS if scheme.refuses(noncommuting())}

    assert refusing == {
        "torchsde-ito[method=milstein]",
        "torchsde-ito[method=srk]",
        "torchsde-stratonovich[method=milstein]",
    }


@pytest.mark.parametrize(
    ("arguments", "message"),
    [(("heun",), "method must be one of euler, milstein, srk, got 'heun'"), (("euler", True), "option of milstein")],
)
def test_method_is_checked(arguments, message):
    """A method of the other calculus, or an option of another method, is refused."""
    with pytest.raises(ParameterError, match=message):
        TorchSDEIto(*arguments)


@pytest.mark.parametrize("library", ["torchsde", "diffrax", "tinydiffeq"])
def test_listing_does_not_load_the_library(library):
    """Registering the schemes of a library that takes seconds to load takes none."""
    program = f"import sys, sdaeverify_bridges.{library} as plugin; print({{'torch', 'jax'}} & set(sys.modules))"

    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "set()"
