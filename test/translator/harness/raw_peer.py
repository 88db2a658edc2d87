"""Hand-made TCPROS and XML-RPC: what no well-behaved node would send."""

import socket
import struct
import urllib.parse
import xmlrpc.client


def header(**fields):
    """A connection header with its length in front."""
    parts = b"".join(struct.pack("<I", len(field)) + field for field in (f"{k}={v}".encode() for k, v in fields.items()))
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
