"""What the wrapper does where torchsde is not installed, and that listing it never loads torch."""

import subprocess
import sys

import pytest
from sdaeverify_torchsde import torchsde_method
from sdaeverify_torchsde.torchsde_method import TorchSDEMethod

from sdaeverify import SDE, ParameterError


@pytest.fixture
def problem():
    """Return an equation with additive noise."""
    return SDE(
        drift=lambda t, x: -x,
        diffusion=lambda t, x: 0.0 * x[:, None] + 1.0,
        start=[1.0],
        noise_dim=1,
        horizon=1.0,
        source="a test",
    )


def test_absent_library_is_the_reason_of_a_refusal(problem, monkeypatch):
    """Every problem is refused, and the reason says what to install."""
    monkeypatch.setattr(torchsde_method, "find_spec", lambda name: None)

    assert TorchSDEMethod().refuses(problem) == "torchsde is not installed; pip install 'sdaeverify-torchsde[torch]'"


def test_listing_does_not_load_torch():
    """The plugin registers its schemes without importing torch, which takes seconds."""
    plugin = "sdaeverify_torchsde.torchsde_method"
    program = f"import sys, {plugin} as plugin; plugin.sdaeverify_schemes(); print('torch' in sys.modules)"

    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)

    assert found.stdout.strip() == "False"


def test_method_is_checked():
    """A method that torchsde has for other equations only is refused."""
    with pytest.raises(ParameterError, match="method must be euler, milstein, srk, got 'heun'"):
        TorchSDEMethod("heun")
