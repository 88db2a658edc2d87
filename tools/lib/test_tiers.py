"""Marks of tests that tools/test reads; without it they do nothing."""


def long_scenario(why):
    """Decorates a test method or class that only `tools/test --all` and `tools/test NAME` run; `why` says what of it a
    shorter test covers, or what it costs."""
    def mark(test):
        test.long_scenario = why
        return test
    if not isinstance(why, str):
        raise TypeError("long_scenario needs a reason")
    return mark
