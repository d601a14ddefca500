"""What can go wrong, by kind: bad input, no feasible answer, a run that ended early but safely."""

from __future__ import annotations


class SteeplejackError(Exception):
    """Every error this package raises on purpose."""


class InputError(SteeplejackError):
    """A file, field or option that cannot be used; the message is one line.

    Args:
        where: File (with line and column where known), option or field.
        what: What was found there.
        valid: What would be valid.
    """

    def __init__(self, where: str, what: str, valid: str) -> None:
        self.where, self.what, self.valid = where, what, valid
        super().__init__(f"{where}: {what}; {valid}")


class InfeasibleError(SteeplejackError):
    """No feasible answer exists; ``binding`` names the limit that rules it out.

    Args:
        what: What was asked for.
        binding: The limit that binds.
    """

    def __init__(self, what: str, binding: str) -> None:
        self.what, self.binding = what, binding
        super().__init__(f"{what}: {binding}")
