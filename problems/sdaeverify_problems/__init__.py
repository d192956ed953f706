"""The problems shipped with sdaeverify: each module is a plugin of its own, and a new problem is a new module."""
