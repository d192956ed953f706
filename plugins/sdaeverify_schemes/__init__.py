"""The schemes shipped with sdaeverify: a folder a family; each module is a plugin, a new scheme is a new module."""
