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

    def __init__(self, kind: str, name: str, valid: Iterable[object]) -> None:
        listed = ", ".join(sorted(str(v) for v in valid))
        super().__init__(f"no {kind} '{name}'; valid: {listed}")


class PhysicsError(FollowerError):
    """The simulated physics left the finite numbers, and where that began; or its engine is gone."""
