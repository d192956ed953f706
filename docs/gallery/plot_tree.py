"""
A wrong coefficient, found by its tree
======================================

Platen's explicit scheme of weak order 2 evaluates the drift at the end of the step, at time t + h. The scheme of this
example has a mistake: it evaluates this drift at time t.

On an equation that does not depend on time, such as most test equations, the mistake has no effect. Order conditions
find it without any test equation, because time is one of the leaves of the trees.
"""

from pathlib import Path
from tempfile import mkdtemp
from typing import ClassVar

import numpy as np
from matplotlib import pyplot as plt

from sdaeverify import SDE, THREE_POINT, Claim, Law, Scheme, Step, verify
from sdaeverify_orders import orders


class SlippedPlaten(Scheme):
    """Platen's scheme for scalar noise, whose second evaluation of the drift is at time t in place of t + h."""

    name: ClassVar[str] = "slipped-platen"
    form: ClassVar[type[SDE]] = SDE
    law: ClassVar[Law] = THREE_POINT
    claims: ClassVar[tuple[Claim, ...]] = (Claim(measure="weak", value=2.0, source="as Platen's"),)

    def refuses(self, problem):
        """Refuse several Brownian motions."""
        return "" if problem.noise_dim == 1 else "needs scalar noise"

    def step(self, problem, state, t, h, noise):
        """Make one step; the state has shape (d, P)."""
        x, dW, root = state, noise.dW, np.sqrt(h)
        f, b = problem.drift(t, x), problem.diffusion(t, x)[:, 0]
        up, down = (problem.diffusion(t + h, x + h * f + sign * root * b)[:, 0] for sign in (1.0, -1.0))
        late = problem.drift(t, x + h * f + b * dW)  # the slip: t + h is right
        kick = 0.25 * ((up + down + 2.0 * b) * dW + (up - down) * (dW**2 - h) / root)
        return Step(x + 0.5 * h * (f + late) + kick)


# %%
# On geometric Brownian motion, and on a double well, the claim is verified.

result = verify([SlippedPlaten()], ["gbm", "double-well"], "weak")
result

# %%
# For the class of all equations with scalar noise it is refuted. The tree ``f(t)`` is the derivative of the drift in
# time; its weight has to be 1/2, and it is 0.

report = orders(SlippedPlaten(), "scalar")
print(report.table[["class", "measure", "claim", "order", "first", "found", "wanted"]].to_string(index=False))

# %%
# The report writes the condition as a problem, a plugin file. On this problem the scheme does not have its order, in
# one step and along paths.

file = Path(mkdtemp()) / "counterexample.py"
file.write_text(report.to_problem(report.failing[0]))
missed = verify([SlippedPlaten()], "counterexample", "weak", plugins=[file])

figure, axes = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
result.plot.convergence("slipped-platen", "gbm", "weak", ax=axes[0])
missed.plot.convergence("slipped-platen", "counterexample", "weak", ax=axes[1])

# %%
# The build of this site fails if the verdicts differ from this text.

assert set(result.verdicts.verdict[result.verdicts.claim.notna()]) == {"verified"}
assert report.failing[0].name == "f(t)"
wrong = missed.verdicts.query("verdict == 'refuted'")
assert set(wrong.decided_by) == {"T1"}
assert wrong.reason.str.startswith("Weak order 1.00 from one step").all()
