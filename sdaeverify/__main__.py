"""Entry point of ``python -m sdaeverify``, the same program as the console script."""

from .cli.main import run

if __name__ == "__main__":
    run()
