r"""A solver in Python for sdaeverify, by version 1 of its wire. Copy this file; it only needs the standard library.

Use it for solvers in another interpreter or environment than sdaeverify. An array is a pair of its shape and its
numbers, paths last: row i of path p of an array of shape (k, P) is ``data[i * P + p]``::

    from sdaeverify_client import Numbers, serve

    def step(given, ask):
        t, h, x, dW = given["t"], given["h"].data[0], given["x"], given["dW"]
        f, B = ask("drift", t=t, x=x), ask("diffusion", t=t, x=x)
        d, P = x.shape
        new = [x.data[i] + h * f.data[i] + B.data[i] * dW.data[i % P] for i in range(d * P)]
        return {"x": Numbers(x.shape, new)}

    needs = "needs scalar-noise\nasks drift diffusion\n"
    serve("name my-euler\nform SDE\nnoise dW\n" + needs + "claim strong 0.5 source my paper\n", step)

With NumPy, ``numpy.frombuffer(x.data).reshape(x.shape)`` is an array, and ``Numbers(y.shape, y.ravel())`` an answer.
"""

import sys
from array import array
from collections import namedtuple

Numbers = namedtuple("Numbers", "shape data")


def serve(hello, step, enter=None):
    """Answer messages until the input ends.

    Parameters
    ----------
    hello : str
        Lines of the hello that describe the solver.
    step : callable, (given, ask) -> dict of str to Numbers
        ``given`` holds arrays by name; ``ask(name, **arrays)`` returns a coefficient; the result is the new state.
    enter : callable, (given, ask) -> dict of str to Numbers, optional
        Needed for a hello with ``memory``: returns the given state and the initial memory.
    """
    while True:
        word, given = read_message()
        if word == "":
            return
        if word == "hello":
            sys.stdout.buffer.write(hello.encode("ascii"))
            write_message("hello", {"version": Numbers((1,), [1.0])})
        else:
            try:
                answer = (enter if word == "enter" else step)(given, ask)
            except Exception as error:
                why = f"{type(error).__name__}: {error}".encode("ascii", "replace").replace(b"\n", b" ")
                sys.stdout.buffer.write(b"error " + why[:2000] + b"\n")
                raise
            write_message("done", answer)


def ask(name, **arrays):
    """Return a coefficient of the problem at any batch of states."""
    write_message(f"ask {name}", arrays)
    return read_message()[1][name]


def read_message():
    """Return the word of the next message and its arrays; the word is empty at the end of the input."""
    words = sys.stdin.buffer.readline().decode("ascii").split()
    if not words:
        return "", {}
    arrays = {}
    for name, shape in (word.split("=") for word in words[1:]):
        lengths = tuple(map(int, shape.split("x")))
        size = 8
        for length in lengths:
            size *= length
        data = array("d", sys.stdin.buffer.read(size))
        if sys.byteorder == "big":
            data.byteswap()
        arrays[name] = Numbers(lengths, data)
    return words[0], arrays


def write_message(words, arrays):
    """Write a message."""
    shapes = [f"{name}={'x'.join(map(str, numbers.shape))}" for name, numbers in arrays.items()]
    sys.stdout.buffer.write((" ".join([words, *shapes]) + "\n").encode("ascii"))
    for numbers in arrays.values():
        data = array("d", numbers.data)
        if sys.byteorder == "big":
            data.byteswap()
        sys.stdout.buffer.write(data.tobytes())
    sys.stdout.buffer.flush()
