#!/usr/bin/env python3
"""A ROS node on strings, like puppet_main.cpp: reads commands from standard input, writes reports to standard output.

Bytes are written as "x" and two hexadecimal digits each: a serialized message, request, goal, ...

  command                                reports
  advertise TOPIC TYPE LATCH(0|1)
  unadvertise TOPIC
  publish TOPIC BYTES
  repeat TOPIC HZ COUNT BYTES            repeated TOPIC COUNT
  stream TOPIC HZ COUNT                  repeated TOPIC COUNT     std_msgs/Float64: the time of sending [s]
  number TOPIC HZ COUNT                  repeated TOPIC COUNT     sensor_msgs/JointState: stamped, and numbered (Python only)
  hang_up TOPIC                          closes its connections (Python only)
  stop TOPIC                             ends repeat, stream and number
  subscribe TOPIC TYPE                   message TOPIC CALLERID BYTES, for each message
  unsubscribe TOPIC
  serve NAME TYPE (RESPONSE|-)           request NAME BYTES, for each call; "-": the server fails
  unserve NAME
  call NAME TYPE BYTES                   response NAME (ok|failed) BYTES TEXT
  action_server NAME TYPE                goal NAME BYTES; preempt NAME
  feedback NAME BYTES
  succeed|abort|preempted NAME BYTES TEXT
  action_client NAME TYPE
  wait_server NAME SECONDS               connected NAME (0|1)
  send_goal NAME BYTES                   active NAME; feedback NAME BYTES; done NAME STATE BYTES TEXT
  cancel NAME
  log error|warn|info TEXT

Every command is answered by "ok COMMAND" or "error ...". Which classes the types are, the PYTHONPATH decides.
"""

import io
import itertools
import sys
import threading
import time

import actionlib
import roslib.message
import rospy
from actionlib_msgs.msg import GoalStatus

_reporting = threading.Lock()


def report(*arguments):
    with _reporting:
        sys.stdout.write(" ".join(map(str, arguments)).replace("\n", " ") + "\n")
        sys.stdout.flush()


def to_hex(message):
    buffer = io.BytesIO()
    if message is not None:
        message.serialize(buffer)
    return "x" + buffer.getvalue().hex()


def from_hex(kind, text):
    return kind().deserialize(bytes.fromhex(text[1:]))


def name_of(state):
    """Of a constant of GoalStatus."""
    return next(name for name, value in vars(GoalStatus).items() if name.isupper() and value == state)


class Puppet:
    def __init__(self):
        self.publishers = {}
        self.repeating = set()
        self.subscribers = {}
        self.servers = {}
        self.action_servers = {}
        self.action_clients = {}

    def obey(self, line):
        arguments = line.split()
        try:
            getattr(self, "do_" + arguments[0])(*arguments[1:])
            report("ok", arguments[0])
        except Exception as error:  # a test must hear of everything
            report("error", line[:200], repr(error))

    # Topics

    def do_advertise(self, topic, type_name, latch):
        kind = roslib.message.get_message_class(type_name)
        self.publishers[topic] = rospy.Publisher(topic, kind, queue_size=1000, latch=latch == "1", tcp_nodelay=True)

    def do_unadvertise(self, topic):
        self.publishers.pop(topic).unregister()

    def do_publish(self, topic, text):
        publisher = self.publishers[topic]
        publisher.publish(from_hex(publisher.data_class, text))

    def do_repeat(self, topic, hz, count, text):
        publisher = self.publishers[topic]
        message = from_hex(publisher.data_class, text)
        self._repeat(topic, float(hz), int(count), lambda: publisher.publish(message))

    def do_stream(self, topic, hz, count):
        publisher = self.publishers[topic]
        self._repeat(topic, float(hz), int(count), lambda: publisher.publish(time.time()))

    def do_number(self, topic, hz, count):
        """Messages of sensor_msgs/JointState with a stamp, whose names are 0, 1, 2, ..."""
        publisher, numbers = self.publishers[topic], itertools.count()

        def once():
            message = publisher.data_class(name=[str(next(numbers))])
            message.header.stamp = rospy.Time.now()
            publisher.publish(message)
        self._repeat(topic, float(hz), int(count), once)

    def do_hang_up(self, topic):
        """Closes all connections of a publisher, as a node that is overloaded or confused does."""
        for connection in self.publishers[topic].impl.connections:
            connection.close()

    def _repeat(self, topic, hz, count, once):
        def run():
            begin = time.monotonic()
            sent = 0
            while sent < count and topic in self.repeating:
                once()
                sent += 1
                time.sleep(max(0.0, begin + sent / hz - time.monotonic()))
            report("repeated", topic, sent)
        self.repeating.add(topic)
        threading.Thread(target=run, daemon=True).start()

    def do_stop(self, topic):
        self.repeating.discard(topic)

    def do_subscribe(self, topic, type_name):
        kind = roslib.message.get_message_class(type_name)

        def hear(message):
            report("message", topic, message._connection_header["callerid"], to_hex(message))
        self.subscribers[topic] = rospy.Subscriber(topic, kind, hear, tcp_nodelay=True)

    def do_unsubscribe(self, topic):
        self.subscribers.pop(topic).unregister()

    # Services

    def do_serve(self, name, type_name, response):
        kind = roslib.message.get_service_class(type_name)

        def answer(request):
            report("request", name, to_hex(request))
            if response == "-":
                raise rospy.ServiceException("the server of %s has no answer" % name)
            return from_hex(kind._response_class, response)
        self.servers[name] = rospy.Service(name, kind, answer)

    def do_unserve(self, name):
        self.servers.pop(name).shutdown()

    def do_call(self, name, type_name, request):
        kind = roslib.message.get_service_class(type_name)

        def run():
            try:
                response = rospy.ServiceProxy(name, kind)(from_hex(kind._request_class, request))
                report("response", name, "ok", to_hex(response))
            except (rospy.ServiceException, OSError) as error:
                report("response", name, "failed", "x", error)
        threading.Thread(target=run, daemon=True).start()

    # Actions

    def do_action_server(self, name, type_name):
        kind = roslib.message.get_message_class(type_name + "Action")
        server = actionlib.SimpleActionServer(name, kind, auto_start=False)
        self.action_servers[name] = server, kind()
        server.register_goal_callback(lambda: report("goal", name, to_hex(server.accept_new_goal())))
        server.register_preempt_callback(lambda: report("preempt", name))
        server.start()

    def do_feedback(self, name, text):
        server, action = self.action_servers[name]
        server.publish_feedback(from_hex(type(action.action_feedback.feedback), text))

    def _finish(self, how, name, text, arguments):
        server, action = self.action_servers[name]
        getattr(server, how)(from_hex(type(action.action_result.result), text), " ".join(arguments))

    def do_succeed(self, name, text, *arguments):
        self._finish("set_succeeded", name, text, arguments)

    def do_abort(self, name, text, *arguments):
        self._finish("set_aborted", name, text, arguments)

    def do_preempted(self, name, text, *arguments):
        self._finish("set_preempted", name, text, arguments)

    def do_action_client(self, name, type_name):
        kind = roslib.message.get_message_class(type_name + "Action")
        self.action_clients[name] = actionlib.SimpleActionClient(name, kind), kind()

    def do_wait_server(self, name, seconds):
        client, _ = self.action_clients[name]

        def run():
            report("connected", name, int(client.wait_for_server(rospy.Duration(float(seconds)))))
        threading.Thread(target=run, daemon=True).start()

    def do_send_goal(self, name, text):
        client, action = self.action_clients[name]

        def done(state, result):
            # The client is not done before this returns: a goal sent meanwhile would confuse it.
            threading.Thread(target=report_done, args=(state, result), daemon=True).start()

        def report_done(state, result):
            client.wait_for_result()
            report("done", name, name_of(state), to_hex(result), client.get_goal_status_text())
        client.send_goal(from_hex(type(action.action_goal.goal), text), done_cb=done,
                         active_cb=lambda: report("active", name),
                         feedback_cb=lambda feedback: report("feedback", name, to_hex(feedback)))

    def do_cancel(self, name):
        self.action_clients[name][0].cancel_goal()

    # Others

    def do_log(self, level, text):
        {"error": rospy.logerr, "warn": rospy.logwarn, "info": rospy.loginfo}[level](text)


def main():
    rospy.init_node("puppet", disable_signals=True)
    puppet = Puppet()
    report("ready")
    for line in sys.stdin:
        puppet.obey(line)
    rospy.signal_shutdown("standard input ended")


if __name__ == "__main__":
    main()
