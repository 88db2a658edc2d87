"""Python side of extperfc: perception that extends a robot's view of its surroundings."""

import pkgutil

# The messages and services of this package are made elsewhere, in the workspace: extperfc.msg, extperfc.srv.
__path__ = pkgutil.extend_path(__path__, __name__)
