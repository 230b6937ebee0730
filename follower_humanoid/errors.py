"""Errors that carry their evidence: what, where, which values are valid."""

from __future__ import annotations

from collections.abc import Iterable

BAD_CONFIGURATION = 2  # exit status of a program that a `ConfigurationError` ends


class FollowerError(Exception):
    """Base class of every error this package raises on purpose."""


class ConfigurationError(FollowerError):
    """A parameter, file or option is not usable; the message is one line fit for a user."""


class UnknownNameError(ConfigurationError):
    """A name that does not exist; the message lists the valid ones."""

    def __init__(
        self, kind: str, name: str, valid: Iterable[object], where: object = "", hint: str = ""
    ) -> None:
        """Makes the message, such as "FILE: no node 'gate'; valid: leader, simulator".

        Args:
            kind: What the name should be of.
            name: The name that does not exist.
            valid: Those that do.
            where: File, option or part of it that holds the name.
            hint: What may have been meant.
        """
        place = f"{where}: " if where else ""
        meant = f" ({hint})" if hint else ""
        super().__init__(f"{place}no {kind} '{name}'{meant}; valid: {_listed(valid)}")


def _listed(names: Iterable[object]) -> str:
    """Names in their order, in quotes where one of them holds the comma that stands between them."""
    texts = sorted(str(name) for name in names)
    if any("," in text for text in texts):
        texts = [f"'{text}'" for text in texts]
    return ", ".join(texts) or "none"


class PhysicsError(FollowerError):
    """The simulated physics left the finite numbers, and where that began; or its engine is gone."""
