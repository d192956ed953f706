"""The registry: what plugins register, where they come from, and which of it a request means."""
