"""Order conditions of the classes that a form poses itself: other nodes than drift, noise and time."""
