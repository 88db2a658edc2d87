"""What a ROS master knows, so that a master that starts again gets it back.

A node registers each topic and service once. A master that starts again knows no node and no parameter: connections between nodes stay, but
a node that starts then finds no topic, no service and no setting. The API of a master and of nodes: http://wiki.ros.org/ROS/Master_API,
http://wiki.ros.org/ROS/Slave_API.
"""

import concurrent.futures
import dataclasses
import typing
import xmlrpc.client

from extperfc.health.ping import FAILURES, answers, proxy

TIMEOUT_S = 5.0   # of a request to the master: robot descriptions are long, and it may be busy
ASKED_AT_ONCE = 8  # nodes
ANY_TYPE = "*"    # of a topic that only subscribers without a type have registered


@dataclasses.dataclass(frozen=True)
class Registrations:
    """nodes: {name: URI}; types: {topic: type}; publishers, subscribers: {topic: names of nodes};
    services: {name: (name of the node, URI of the service)}; parameters: the whole tree."""
    nodes: typing.Dict[str, str] = dataclasses.field(default_factory=dict)
    types: typing.Dict[str, str] = dataclasses.field(default_factory=dict)
    publishers: typing.Dict[str, typing.List[str]] = dataclasses.field(default_factory=dict)
    subscribers: typing.Dict[str, typing.List[str]] = dataclasses.field(default_factory=dict)
    services: typing.Dict[str, typing.Tuple[str, str]] = dataclasses.field(default_factory=dict)
    parameters: dict = dataclasses.field(default_factory=dict)

    def apis(self, names):
        """URIs of nodes, without those that are unknown."""
        return [self.nodes[name] for name in names if name in self.nodes]


def missing(wanted, present):
    """[(name, value)] of parameters in the tree `wanted` that the tree `present` lacks; subtrees that it lacks as a whole."""
    found = []
    for key, value in wanted.items():
        if key not in present:
            found.append((key, value))
        elif isinstance(value, dict) and isinstance(present[key], dict):
            found += [(f"{key}/{name}", inner) for name, inner in missing(value, present[key])]
    return found


class Master:
    """A ROS master as the node `caller` asks it. Every method raises one of ping.FAILURES."""

    def __init__(self, uri, caller):
        self._uri, self._caller = uri, caller

    def ask(self, *calls):
        """Values of calls (method, name of the calling node, argument, ...) in one request; None where the master refuses one."""
        if not calls:
            return []
        with proxy(self._uri, TIMEOUT_S) as master:
            requests = xmlrpc.client.MultiCall(master)
            for method, *arguments in calls:
                getattr(requests, method)(*arguments)
            return [value if code == 1 else None for code, _, value in requests()]

    def knows(self, node):
        return self.ask(("lookupNode", self._caller, node)) != [None]

    def read(self):
        """Registrations."""
        me = self._caller
        state, types, parameters = self.ask(("getSystemState", me), ("getTopicTypes", me), ("getParam", me, "/"))
        publishers, subscribers, services = state
        names = sorted({name for kind in (publishers, subscribers, services) for _, nodes in kind for name in nodes})
        found = self.ask(*(("lookupNode", me, name) for name in names), *(("lookupService", me, name) for name, _ in services))
        return Registrations(
            {name: uri for name, uri in zip(names, found) if uri}, dict(types), dict(publishers), dict(subscribers),
            {name: (nodes[0], uri) for (name, nodes), uri in zip(services, found[len(names):]) if uri and nodes}, parameters)

    def restore(self, noted):
        """Gives the master the noted Registrations of nodes that still live, and the parameters that it lacks.
        Returns (names of the nodes, number of parameters; a subtree counts as one)."""
        parameters = missing(noted.parameters, self.ask(("getParam", self._caller, "/"))[0])
        self.ask(*(("setParam", self._caller, "/" + name, value) for name, value in parameters))
        nodes = self._restorable(noted)
        # Publishers first: a registered subscriber hears of each change, and leaves the publishers that are not listed yet.
        self.ask(*(("registerPublisher", node, topic, noted.types.get(topic, ANY_TYPE), nodes[node])
                   for topic, node in _pairs(noted.publishers, nodes)))
        self.ask(*(("registerService", node, service, uri, nodes[node])
                   for service, (node, uri) in noted.services.items() if node in nodes))
        subscribers = _pairs(noted.subscribers, nodes)
        publishers = self.ask(*(("registerSubscriber", node, topic, noted.types.get(topic, ANY_TYPE), nodes[node])
                                for topic, node in subscribers))
        for (topic, node), uris in zip(subscribers, publishers):
            if uris is not None and set(uris) != set(noted.apis(noted.publishers.get(topic, []))):
                _update_publishers(nodes[node], topic, uris)
        return sorted(nodes), len(parameters)

    def _restorable(self, noted):
        """{name: URI} of nodes that live. Without those that the master knows by another URI: they have started since, and the
        master would end them for an older one of the same name."""
        known = self.ask(*(("lookupNode", self._caller, name) for name in noted.nodes))
        nodes = {name: uri for (name, uri), present in zip(noted.nodes.items(), known) if present in (None, uri)}
        with concurrent.futures.ThreadPoolExecutor(ASKED_AT_ONCE) as pool:
            alive = pool.map(lambda uri: answers(uri, self._caller), nodes.values())
            return {name: uri for (name, uri), lives in zip(nodes.items(), alive) if lives}


def _pairs(topics, nodes):
    """[(topic, node)] of {topic: names}, of the nodes alone."""
    return [(topic, node) for topic, names in topics.items() for node in names if node in nodes]


def _update_publishers(uri, topic, publishers):
    """Reports to the node at this URI who publishes a topic, as the master does."""
    try:
        with proxy(uri) as node:
            node.publisherUpdate("/master", topic, publishers)
    except FAILURES:
        pass  # it ended meanwhile
