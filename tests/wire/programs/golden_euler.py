"""Euler's scheme in Python without NumPy, which answers as the golden transcript does."""

from sdaeverify_client import Numbers, serve


def step(given, ask):
    """Return x + h f + B dW."""
    t, h, x, dW = given["t"], given["h"].data[0], given["x"], given["dW"]
    f, B = ask("drift", t=t, x=x), ask("diffusion", t=t, x=x)
    (d, P), l = x.shape, dW.shape[0]
    new = [x.data[i] + h * f.data[i] for i in range(d * P)]
    for i in range(d * P):
        for j in range(l):
            new[i] += B.data[(i // P * l + j) * P + i % P] * dW.data[j * P + i % P]
    return {"x": Numbers(x.shape, new)}


serve("name golden-euler\nform SDE\nnoise dW\nasks drift diffusion\n", step)
