r"""
Jump-diffusion, a form of its own
=================================

Merton's model has jumps. Neither its form nor its noise is part of the framework. A plugin defines both: the
equation, the record of jump times and marks, which is refined from level to level like a Brownian path, the trivial
equations that a step has to solve exactly, and the schemes.

.. math::

    \,dx = \mu x \,dt + \sigma x \,dW + x^{-} \,dJ

All of it is in the folder ``tests/thirdparty/jump_diffusion`` of the source distribution.
"""

import sys
from dataclasses import replace

from matplotlib import pyplot as plt

from sdaeverify import sample, verify

sys.path.append("../../tests/thirdparty/jump_diffusion/src")
from sdaeverify_jumps._jump_diffusion import JumpDiffusion
from sdaeverify_jumps.geometric_jumps import geometric_jumps
from sdaeverify_jumps.jump_euler import CompensatedJumpEuler, JumpEuler, MarcusJumpEuler


def merton() -> JumpDiffusion:
    """Merton's model with marks of two values; its controls are registered where the plugin is installed."""
    return replace(geometric_jumps(), controls=())


paths = sample(JumpEuler(), merton, steps=512, paths=12)
figure, ax = plt.subplots(figsize=(7, 3), layout="constrained")
axes = paths.plot(ax=ax)

# %%
# Euler's scheme with jumps, a variant that subtracts their mean, and a variant with Marcus' canonical jumps. All
# three claim strong order 1/2 and weak order 1.

wrong = [CompensatedJumpEuler(), MarcusJumpEuler()]
result = verify([JumpEuler(), *wrong], merton, "strong,weak", paths=4096)
result

# %%

verdicts = result.verdicts.groupby("scheme").verdict.agg(set)
print(verdicts.to_string())
assert "verified" in verdicts["jump-euler"]
assert "refuted" not in verdicts["jump-euler"]
wrong = result.verdicts.query("scheme == 'marcus-jump-euler' and verdict == 'refuted'")
assert set(wrong.decided_by) == {"T1", "T3"}
assert set(wrong.reason_kind) == {"one step does not follow the equation", "order"}
