"""A server that runs a program for each connection to a local socket, which is the stdin and stdout of the program.

python listening.py ADDRESS PROGRAM [ARGUMENT]...
"""

import os
import signal
import socket
import sys


def listening(address):
    """Return a socket that listens on ``unix:PATH`` or ``tcp:localhost:PORT``."""
    if address.startswith("unix:"):
        listener = socket.socket(socket.AF_UNIX)
        listener.bind(address.removeprefix("unix:"))
        listener.listen()
        return listener
    return socket.create_server(("localhost", int(address.rpartition(":")[2])))


def main(address, *command):
    """Accept connections until the process is ended."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    listener = listening(address)
    print("ready", flush=True)
    while True:
        connection, _ = listener.accept()
        if os.fork() == 0:
            os.dup2(connection.fileno(), 0)
            os.dup2(connection.fileno(), 1)
            os.closerange(3, 64)
            os.execv(command[0], command)
        connection.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
