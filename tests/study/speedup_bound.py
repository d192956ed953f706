"""Tell how much faster any number of workers can make a run: `python tests/study/speedup_bound.py FOLDER`.

From the measured seconds in the evidence of a run. A scheme on a problem is the smallest piece; paths are drawn when
all that needs none is found; a problem takes its next look when its slowest scheme is done with the last one.
"""

import sys
from collections import defaultdict
from pathlib import Path

from sdaeverify.store.container import containers

# What evidence without paths is called in the files.
SCREENED = "step"


def pieces(folder):
    """Return the seconds of each piece of work: by problem and block, on few levels or on all, by scheme."""
    found = defaultdict(dict)
    for container in containers(folder):
        for name, lane in container.lanes():
            found[lane.problem, name.partition("-")[0]][lane.scheme] = lane.seconds
    return found


def main(folder):
    """Print the bound, and the two stretches of work that make it up."""
    found = pieces(Path(folder, "evidence"))
    whole = sum(sum(schemes.values()) for schemes in found.values())
    longest = {place: max((each[scheme], scheme) for scheme in each) for place, each in found.items()}
    screening = max((*each, problem) for (problem, block), each in longest.items() if block == SCREENED)
    chains = defaultdict(float)
    for (problem, block), (seconds, _) in longest.items():
        chains[problem] += seconds if block != SCREENED else 0.0
    problem = max(chains, key=chains.__getitem__)
    print(f"all pieces {whole:.1f} s; without paths at least {screening[0]:.1f} s: {screening[1]} on {screening[2]}")
    print(f"look after look at least {chains[problem]:.1f} s: {problem}")
    print(f"at most {whole / (screening[0] + chains[problem]):.1f} times faster")


if __name__ == "__main__":
    main(sys.argv[1])
