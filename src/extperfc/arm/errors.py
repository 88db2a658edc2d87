"""How requests to the arms fail."""

from extperfc.msg import ArmCode


class ClientCode:
    """Failures that the node cannot report, in addition to the codes of extperfc/ArmCode."""
    NOT_RUNNING = -1        # no master, no node, no service, no action
    TIMEOUT = -2            # of the caller; the motion was cancelled
    REJECTED = -3           # the action refused the goal without a code
    CONNECTION_LOST = -4    # the connection to the node was lost during the request


def _constants(owner):
    return {value: name for name, value in vars(owner).items() if name.isupper() and isinstance(value, int)}


NAMES = {**_constants(ArmCode), **_constants(ClientCode)}


class ArmError(Exception):
    """A request failed.

    code: a number of extperfc/ArmCode or of ClientCode; name: its name, e.g. GOAL_IN_COLLISION; message: what was
    wrong and what to do; result: the action's result, where there is one.
    """

    def __init__(self, code, message, result=None):
        self.code = int(code)
        self.name = NAMES.get(self.code, f"CODE_{self.code}")
        self.message = message
        self.result = result
        super().__init__(f"{self.name}: {message}" if message else self.name)
