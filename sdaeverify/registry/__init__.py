"""The registry: objects that plugins register, their origins, and selection by name or pattern."""
