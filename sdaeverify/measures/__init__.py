"""The shipped measures: each module is a plugin, one question a file."""
