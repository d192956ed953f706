"""Plugins that fail, each in its own way: every module is an entry point of its own."""
