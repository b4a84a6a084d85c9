"""What symkin raises. Each message is a sentence: what is wrong, where, and what is allowed."""

from symkin.text import shortened


class SymkinError(Exception):
    """Base of every error that symkin raises on purpose: catch it to catch them all. Long values in
    its message are cut.

    >>> import symkin
    >>> try:
    ...     symkin.load("no_such_mechanism.toml")
    ... except symkin.SymkinError as error:
    ...     print(error)
    no_such_mechanism.toml: there is no such file
    """

    def __init__(self, message: object = "") -> None:
        super().__init__(shortened(str(message)))


class MechanismError(SymkinError):
    """A mechanism description that cannot be right: names the key path, its value and what is
    allowed.

    >>> import symkin
    >>> symkin.Joint("hinge", "X")
    Traceback (most recent call last):
    symkin.errors.MechanismError: joint 'hinge': type = 'X' is unknown; allowed: R, P, H, C, U, S
    """


class InputError(SymkinError):
    """Joint values, a pose, a start or an option that does not fit the mechanism.

    >>> import symkin
    >>> symkin.solve(symkin.load("zhao2000"), joints={"theta1": 80.0})
    Traceback (most recent call last):
    symkin.errors.InputError: joints: no value is given for theta2, theta3, op; the actuated ...
    """


class TooManyModesError(InputError):
    """A problem with more modes than can be listed."""


class NoConfigurationError(InputError):
    """Values at which no configuration closes the loops, where one is needed to begin with; exit
    status 3 of a command.
    """
