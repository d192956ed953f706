"""The schemes shipped with sdaeverify: each module is a plugin of its own, and a new scheme is a new module."""
