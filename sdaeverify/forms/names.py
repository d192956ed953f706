"""How the names of forms stand in a sentence."""

# Letters whose names begin with a vowel: an SDE, a DelaySDAE.
SPOKEN_WITH_VOWEL = frozenset("AEFHILMNORSX")


def article(name: str) -> str:
    """Return a name with its article: an SDE, a HolonomicSDAE, an IndexOneSDAE.

    Parameters
    ----------
    name : str
        Of a class; its first letters are spoken one by one where they are capitals.
    """
    spelled = len(name) > 1 and name[:2].isupper()
    vowel = name[:1] in SPOKEN_WITH_VOWEL if spelled else name[:1].lower() in "aeio"
    return f"{'an' if vowel else 'a'} {name}"
