"""A program with memory: the state stays where it is, and the memory is the time since it was entered."""

from sdaeverify_client import Numbers, serve


def enter(given, ask):
    """Return the state and no time."""
    x = given["x"]
    return {"x": x, "memory": Numbers((1, x.shape[1]), x.shape[1] * [0.0])}


def step(given, ask):
    """Return the state, and the time with a step more."""
    h = given["h"].data[0]
    return {"x": given["x"], "memory": Numbers(given["memory"].shape, [t + h for t in given["memory"].data])}


serve("name remembers\nform SDE\nmemory 1\n", step, enter)
