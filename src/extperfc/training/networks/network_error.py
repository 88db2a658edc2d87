"""Errors of this package; apart from the networks, so that nothing here needs PyTorch."""

from ..errors import UserError


class NetworkError(UserError):
    """A network cannot be built, exported, described or quantized; the message names the remedy."""


class RuntimeMissing(NetworkError):
    """A library that runs networks is not installed."""
