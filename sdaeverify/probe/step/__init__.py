"""One step as a black box: its map, the nodes of its noise, the states and times it is probed at."""
