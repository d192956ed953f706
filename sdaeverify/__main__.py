"""``python -m sdaeverify``: the same program as the console script."""

import sys

if __name__ == "__main__":
    try:
        from .cli.main import run
    except KeyboardInterrupt:
        # An interrupt while the libraries are loading ends the program like a later one.
        sys.exit(130)
    run()
