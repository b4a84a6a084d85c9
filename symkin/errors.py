"""What symkin raises. Each message is a sentence: what is wrong, where, and what is allowed."""

from symkin.text import shortened


class SymkinError(Exception):
    """Base of every error that symkin raises on purpose. Long values in its message are cut."""

    def __init__(self, message: object = "") -> None:
        super().__init__(shortened(str(message)))


class MechanismError(SymkinError):
    """A mechanism description that cannot be right: names the key path, its value and what is allowed."""


class InputError(SymkinError):
    """Joint values, a pose, a start or an option that does not fit the mechanism."""


class TooManyModesError(InputError):
    """A problem with more modes than can be listed."""
