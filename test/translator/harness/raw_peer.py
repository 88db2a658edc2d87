"""Hand-made TCPROS and XML-RPC: what no well-behaved node would send."""

import socket
import socketserver
import struct
import threading
import urllib.parse
import xmlrpc.client
import xmlrpc.server


def header(**fields):
    """A connection header with its length in front."""
    encoded = (f"{key}={value}".encode() for key, value in fields.items())
    parts = b"".join(struct.pack("<I", len(field)) + field for field in encoded)
    return struct.pack("<I", len(parts)) + parts


def read_header(stream):
    """The fields of the other end's header; ConnectionError when it hangs up."""
    length, = struct.unpack("<I", read_exactly(stream, 4))
    content, fields = read_exactly(stream, length), {}
    while content:
        size, = struct.unpack("<I", content[:4])
        key, _, value = content[4:4 + size].partition(b"=")
        fields[key.decode()] = value.decode(errors="replace")
        content = content[4 + size:]
    return fields


def read_exactly(stream, count):
    content = b""
    while len(content) < count:
        more = stream.recv(count - len(content))
        if not more:
            raise ConnectionError("the other end hung up")
        content += more
    return content


def address_of(uri):
    parsed = urllib.parse.urlparse(uri)
    return parsed.hostname, parsed.port


def topic_address(place, node_uri, topic):
    """Where a node sends a topic from."""
    with place.inside(), xmlrpc.client.ServerProxy(node_uri) as node:
        code, text, value = node.requestTopic("/harness", topic, [["TCPROS"]])
    if code != 1:
        raise RuntimeError(text)
    return value[1], value[2]


def connect(place, address, seconds=10):
    with place.inside():
        return socket.create_connection(address, timeout=seconds)


def throw(place, address, content, seconds=0.02):
    """Sends bytes, listens a moment, hangs up."""
    with connect(place, address) as stream:
        try:
            stream.sendall(content)
            stream.settimeout(seconds)
            stream.recv(4096)
        except OSError:
            pass


def hostile_contents(rng):
    """Garbage, lies about lengths, and greetings that end early, of TCPROS and XML-RPC."""
    good = header(topic="/hostile_workstation", type="std_msgs/String", md5sum="*", callerid="/bad")
    yield b""
    yield b"\xff" * 8
    yield struct.pack("<I", 0)
    yield struct.pack("<I", 0x7fffffff) + b"topic=/hostile_workstation"
    yield struct.pack("<II", 4, 0xffffffff)
    yield struct.pack("<II", 8, 4) + b"abcd"
    yield header(topic="/hostile_workstation", type="std_msgs/String", md5sum="0" * 32, callerid="/bad")
    yield header(topic="/no_such_topic", type="*", md5sum="*", callerid="/bad")
    yield header(service="/no_such_service", md5sum="*", callerid="/bad")
    yield header(**{f"key{index}": "x" * 100 for index in range(2000)})
    for cut in range(1, len(good), 9):
        yield good[:cut]
    yield good + rng.randbytes(1000)
    yield b"POST / HTTP/1.1\r\nContent-Length: 99999999999\r\n\r\n<methodCall>"
    yield b"POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\n"
    yield b"POST / HTTP/1.1\r\nContent-Length: 60\r\n\r\n<?xml version='1.0'?><methodCall><methodName>shutdown</methodN"
    yield b"GET / HTTP/1.0\r\n\r\n"
    yield b"A" * 200_000
    deep = b"<methodCall><methodName>x</methodName><params>" + b"<param><value><array><data>" * 500
    yield b"POST / HTTP/1.1\r\nContent-Length: %d\r\n\r\n" % len(deep) + deep
    for _ in range(20):
        yield rng.randbytes(rng.randint(1, 400))


class FakePublisher:
    """Registers a topic and answers connections with a given content."""

    def __init__(self, master, topic, type_name, md5):
        self.master, self.topic, self.bodies = master, topic, []
        self.fields = {"type": type_name, "md5sum": md5, "callerid": "/liar", "latching": "0",
                       "message_definition": "string data\n", "topic": topic}
        self.served = threading.Event()
        outer = self

        class Stream(socketserver.BaseRequestHandler):
            def handle(self):
                read_header(self.request)
                self.request.sendall(header(**outer.fields) + outer.bodies[-1])
                outer.served.set()
                self.request.settimeout(1)
                try:
                    self.request.recv(1)
                except OSError:
                    pass
        with master.place.inside():
            socketserver.ThreadingTCPServer.daemon_threads = True
            self.stream = socketserver.ThreadingTCPServer((master.place.address, 0), Stream)
            self.api = xmlrpc.server.SimpleXMLRPCServer((master.place.address, 0), logRequests=False)
        self.api.register_function(lambda *_: [1, "", ["TCPROS", *self.stream.server_address]], "requestTopic")
        self.uri = "http://%s:%d/" % self.api.server_address
        for server in (self.stream, self.api):
            threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()

    def ask(self, method, *arguments):
        with self.master.place.inside(), xmlrpc.client.ServerProxy(self.master.uri) as master:
            return getattr(master, method)("/liar", *arguments)

    def greet(self, body):
        """Has the translator connect, and sends the body behind the header."""
        self.bodies.append(body)
        self.served.clear()
        self.ask("registerPublisher", self.topic, self.fields["type"], self.uri)
        if not self.served.wait(10):
            raise AssertionError("no subscriber connected to the lying publisher")
        self.ask("unregisterPublisher", self.topic, self.uri)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for server in (self.stream, self.api):
            server.shutdown()
            server.server_close()
