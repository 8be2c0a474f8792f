"""Lines for the person: each once, in order."""


class Notes:
    """Collects what is left out or replaced, so that a picture is never wrong in silence."""

    def __init__(self):
        self._lines = {}

    def add(self, owner, line):
        """Notes `line` about `owner`, the name of an object, a material or a light; once."""
        self._lines[f"{owner}: {line}"] = None

    @property
    def lines(self):
        return list(self._lines)

    def extend(self, other):
        self._lines.update(other._lines)


class Refused(Exception):
    """The scene cannot be rendered; the message says why, in one line."""
