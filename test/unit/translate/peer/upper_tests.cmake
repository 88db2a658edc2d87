# TCPROS streams, the node.
