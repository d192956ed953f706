r"""
Kubo oscillator, with a measure of its own
==========================================

A rotation with a noisy frequency conserves its energy on every path. How fast does the energy of a scheme drift? No
shipped measure answers this, so the example defines one, with an equation whose solution is known, a scheme whose
claim holds, and a scheme without Milstein's correction whose claim does not hold.

.. math::

    \,dx = J x (\,dt + \sigma \circ \,dW), \qquad J = (0, 1; -1, 0)
"""

from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt

from sdaeverify import sample, verify

energy = Path("../../tests/thirdparty/energy/src/sdaeverify_energy")
files = [energy / f"{name}.py" for name in ("energy_drift", "energy_defect", "kubo_oscillator", "kubo_schemes")]
paths = [
    sample(scheme, "kubo-oscillator", steps=64, paths=5, plugins=files)
    for scheme in ("kubo-milstein", "kubo-forgetful")
]

figure, axes = plt.subplots(1, 2, figsize=(8, 3), sharey=True, layout="constrained")
for run, ax in zip(paths, axes, strict=True):
    ax.plot(run.times, 0.5 * np.sum(run["x"] ** 2, axis=1))
    ax.set(title=run.scheme, xlabel="t", ylabel="energy")

# %%
# The measure estimates the order in h of the energy drift. Both schemes claim order 1.

result = verify("kubo-*", "kubo-oscillator", "energy-drift", plugins=files, paths=2048)
result

# %%
# The build of this site fails if the verdicts differ from this text.

assert dict(zip(result.verdicts.scheme, result.verdicts.verdict, strict=True)) == {
    "kubo-milstein": "verified",
    "kubo-forgetful": "refuted",
}
assert set(result.verdicts.query("verdict == 'refuted'").reason_kind) == {"order"}
