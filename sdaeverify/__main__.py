"""``python -m sdaeverify``: the same as the console script."""

from .cli.main import run

if __name__ == "__main__":
    run()
