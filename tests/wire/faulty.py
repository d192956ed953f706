"""A program that speaks the wire, but for one fault, which its argument names; without argument it has none."""

import os
import signal
import struct
import sys
import time

FAULT = sys.argv[1] if len(sys.argv) > 1 else ""
ONE, HUGE = struct.pack("<d", 1.0), 10**7
HELLO = b"name faulty\nform SDE\nnoise dW\nasks drift\nclaim strong 0.5 source nowhere\nhello version=1\n" + ONE


def send(content):
    """Write bytes at once."""
    sys.stdout.buffer.write(content)
    sys.stdout.buffer.flush()


def receive():
    """Return the shapes and the bytes of the next message; None at the end."""
    line = sys.stdin.buffer.readline().decode()
    if not line:
        return None
    shapes = dict(word.split("=") for word in line.split()[1:])
    found = {}
    for name, shape in shapes.items():
        size = 8
        for length in shape.split("x"):
            size *= int(length)
        found[name] = sys.stdin.buffer.read(size)
    return shapes, found


def die():
    """End as a program with a segmentation fault does, without its core."""
    os.kill(os.getpid(), signal.SIGKILL)


def say_and_end():
    """End with words on stderr."""
    print("first line\ncannot find licence", file=sys.stderr)
    sys.exit(4)


def flood_stderr():
    """Write more to stderr than a pipe holds, then go on."""
    sys.stderr.write("noise " * (HUGE // 20))
    sys.stderr.flush()
    send(HELLO)


AT_HELLO = {
    "silent": lambda: time.sleep(600),
    "ends": lambda: sys.exit(3),
    "ends without a word": lambda: sys.exit(0),
    "dies": die,
    "other version": lambda: send(HELLO[:-8] + struct.pack("<d", 2.0)),
    "other version in words": lambda: send(b"name faulty\nform SDE\nhello version=1 dialect=1\n"),
    "big-endian": lambda: send(HELLO[:-8] + struct.pack(">d", 1.0)),
    "unknown word": lambda: send(b"name faulty\nlanguage C\n" + HELLO),
    "no name": lambda: send(b"form SDE\nhello version=1\n" + ONE),
    "unknown form": lambda: send(b"name faulty\nform PDE\nhello version=1\n" + ONE),
    "name twice": lambda: send(b"name faulty\n" + HELLO),
    "bad claim": lambda: send(b"claim strong\n" + HELLO),
    "unknown trait": lambda: send(b"claim strong 1 when sunny source nowhere\n" + HELLO),
    "unknown ask": lambda: send(b"name faulty\nform SDE\nasks weather\nhello version=1\n" + ONE),
    "bytes in place of text": lambda: send(bytes(range(256)) + b"\n"),
    "line without end": lambda: send(b"a" * HUGE),
    "lines without end": lambda: [send(b"claim weak 1 source nowhere\n" * 100) for _ in range(10**4)],
    "half a number": lambda: (send(HELLO[:-4]), sys.exit(0)),
    "words on stderr": say_and_end,
    "flood on stderr": flood_stderr,
    "closes its stdout": lambda: (os.close(1), time.sleep(600)),
}


def done(shapes, found, **other):
    """Answer with the old state under a line."""
    line = other.get("line", "done x={x}").format(**shapes)
    send(line.encode() + other.get("end", b"\n") + other.get("content", found["x"]))


P3 = struct.pack("<3d", 0.0, 0.5, 1.0)
IN_STEP = {
    "a row too many": lambda s, f: done(s, f, line="done x=2x3", content=2 * f["x"]),
    "a path too few": lambda s, f: done(s, f, line="done x=1x2", content=f["x"][:16]),
    "paths first": lambda s, f: done(s, f, line="done x=3x1"),
    "another name": lambda s, f: done(s, f, line="done y={x}"),
    "no state": lambda s, f: done(s, f, line="done", content=b""),
    "flags first": lambda s, f: done(s, f, line="done failed=3 x={x}", content=bytes(24) + f["x"]),
    "unknown array": lambda s, f: done(s, f, line="done x={x} error=1x3", content=2 * f["x"]),
    "state twice": lambda s, f: done(s, f, line="done x={x} x={x}", content=2 * f["x"]),
    "flags of another shape": lambda s, f: done(s, f, line="done x={x} failed=1x3", content=2 * f["x"]),
    "flags that are no flags": lambda s, f: done(s, f, line="done x={x} failed=3", content=f["x"] + P3),
    "cost of another shape": lambda s, f: done(s, f, line="done x={x} cost.n=4", content=f["x"] + bytes(32)),
    "ends in an array": lambda s, f: (done(s, f, content=f["x"][:10]), sys.exit(0)),
    "dies in an array": lambda s, f: (done(s, f, content=f["x"][:10]), die()),
    "stops in an array": lambda s, f: (done(s, f, content=f["x"][:10]), time.sleep(600)),
    "single precision": lambda s, f: (done(s, f, content=f["x"][:12]), time.sleep(600)),
    "more than its answer": lambda s, f: done(s, f, content=f["x"] + b"more"),
    "answers twice": lambda s, f: (done(s, f), done(s, f)),
    "no shape": lambda s, f: done(s, f, line="done x=axb"),
    "negative shape": lambda s, f: done(s, f, line="done x=-1x3"),
    "five axes": lambda s, f: done(s, f, line="done x=1x1x1x1x3"),
    "more than there is": lambda s, f: done(s, f, line="done x=9999999999x9999999999"),
    "another word": lambda s, f: done(s, f, line="finished x={x}"),
    "carriage return": lambda s, f: done(s, f, end=b"\r\n"),
    "long line": lambda s, f: done(s, f, line="done x={x}" + 5000 * " "),
    "asks what it did not say": lambda s, f: send(b"ask diffusion t=1 x=1x3\n" + bytes(32)),
    "asks nothing there is": lambda s, f: send(b"ask weather t=1 x=1x3\n" + bytes(32)),
    "asks without a name": lambda s, f: send(b"ask t=1 x=1x3\n" + bytes(32)),
    "asks with rows too many": lambda s, f: send(b"ask drift t=1 x=2x3\n" + bytes(56)),
    "asks without a time": lambda s, f: send(b"ask drift x=1x3\n" + bytes(24)),
    "asks in another order": lambda s, f: send(b"ask drift x=1x3 t=1\n" + bytes(32)),
    "asks too much": lambda s, f: send(b"ask drift t=1 x=1x9999999999\n"),
    "asks and ends": lambda s, f: (send(b"ask drift t=1 x=1x3\n" + bytes(32)), os._exit(5)),
    "asks half and stops": lambda s, f: (send(b"ask drift t=1 x=1x3\n" + bytes(9)), time.sleep(600)),
    "error": lambda s, f: (send(b"error no root within 50 iterations\n"), sys.exit(1)),
    "says hello again": lambda s, f: send(HELLO),
    "silent in a step": lambda s, f: time.sleep(600),
    "dies in a step": lambda s, f: die(),
    "stdin is never read": lambda s, f: None,
    "floods": lambda s, f: [send(b"done x=1x3\n" + f["x"]) for _ in range(10**6)],
    "not a number": lambda s, f: done(s, f, content=len(f["x"]) // 8 * struct.pack("<d", float("nan"))),
}


def main():
    """Say hello, then answer steps."""
    receive()
    AT_HELLO.get(FAULT, lambda: send(HELLO))()
    if FAULT == "stdin is never read":
        time.sleep(600)
    while (message := receive()) is not None:
        IN_STEP.get(FAULT, done)(*message)


if __name__ == "__main__":
    main()
