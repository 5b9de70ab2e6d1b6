"""Text in which line breaks do not count."""


def flat(text):
    """The text with one blank between words, however its lines are wrapped."""
    return " ".join(text.split())
