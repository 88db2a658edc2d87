"""Errors whose message is for the user: what was wrong, where, and what to do."""


class UserError(ValueError):
    """Base of all of them; programs print the message without a traceback."""


class DataError(UserError):
    """Images or labels cannot be used; the message names each problem and the remedy."""


class SettingsError(UserError):
    """Settings cannot be used; the message lists every error."""


class TrainingError(UserError):
    """Training cannot go on; the message names the remedy."""
