#!/usr/bin/python3
"""A node of the soak: numbers what it sends and notes what it hears, in a file that the soak reads afterwards.

Lines of the file: `kind name run number time`. kind: sent, heard, latched, called, failed. run counts the lives of a
talker apart. Times are of the monotonic clock, which every process of a computer shares [s].
"""

import argparse
import threading
import time

import rospy
from control_msgs.msg import JointControllerState
from std_msgs.msg import Float64, String
from std_srvs.srv import Trigger, TriggerResponse


def topics_of(side):
    """{topic: (class, latched)} that the talker of a side publishes. JointControllerState differs between the eras."""
    topics = {
        f"/soak/{side}/pass": (String, False),
        f"/soak/{side}/convert": (JointControllerState, False),
        f"/soak/{side}/latched": (String, True),
        f"/soak/{side}/latched_convert": (JointControllerState, True),
    }
    if side == "workstation":
        topics["/robot/limb/left/joint_command_timeout"] = (Float64, False)
    return topics


SERVICE = "/soak/robot/service"
STEP = 1e7  # numbers of one life of a talker, packed with its run into a float64


def pack(kind, run, number):
    message = kind()
    if kind is String:
        message.data = f"{run} {number}"
    elif kind is Float64:
        message.data = run * STEP + number
    else:
        message.set_point = run * STEP + number
    return message


def unpack(message):
    if isinstance(message, String):
        return tuple(map(int, message.data.split()))
    value = message.data if isinstance(message, Float64) else message.set_point
    return int(value // STEP), int(value % STEP)


class Notes:
    """Appends whole lines, from any thread."""

    def __init__(self, file):
        self._lock = threading.Lock()
        self._file = open(file, "a", buffering=1)

    def write(self, kind, name, run, number):
        with self._lock:
            self._file.write(f"{kind} {name} {run} {number} {time.monotonic():.6f}\n")


def talk(arguments, notes):
    topics = topics_of(arguments.side)
    publishers = {name: rospy.Publisher(name, kind, queue_size=100, latch=latched, tcp_nodelay=True)
                  for name, (kind, latched) in topics.items()}
    if arguments.side == "robot":
        rospy.Service(SERVICE, Trigger, lambda _: TriggerResponse(True, "here"))
    for name, (kind, latched) in topics.items():
        if latched:
            notes.write("latched", name, arguments.run, 1)
            publishers[name].publish(pack(kind, arguments.run, 1))
    number, begin = 0, time.monotonic()
    while not rospy.is_shutdown():
        number += 1
        for name, (kind, latched) in topics.items():
            if not latched:
                notes.write("sent", name, arguments.run, number)
                publishers[name].publish(pack(kind, arguments.run, number))
        time.sleep(max(0.0, begin + number / arguments.rate - time.monotonic()))


def call(notes):
    """Two calls per second, over a new connection each."""
    number = 0
    while not rospy.is_shutdown():
        number += 1
        try:
            answer = rospy.ServiceProxy(SERVICE, Trigger)()
            notes.write("called" if answer.message == "here" else "failed", SERVICE, 0, number)
        except (rospy.ServiceException, rospy.ROSException, OSError):
            notes.write("failed", SERVICE, 0, number)
        time.sleep(0.5)


def listen(arguments, notes):
    for name, (kind, _) in topics_of("workstation" if arguments.side == "robot" else "robot").items():
        rospy.Subscriber(name, kind, lambda message, topic: notes.write("heard", topic, *unpack(message)), name,
                         queue_size=1000, tcp_nodelay=True)
    if arguments.side == "workstation" and arguments.role == "listener":
        threading.Thread(target=call, args=(notes,), daemon=True).start()
    rospy.spin()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--role", choices=("talker", "listener", "late"), required=True)
    parser.add_argument("--side", choices=("robot", "workstation"), required=True)
    parser.add_argument("--run", type=int, default=0)
    parser.add_argument("--rate", type=float, default=20.0)
    parser.add_argument("--file", required=True)
    arguments = parser.parse_args()
    notes = Notes(arguments.file)
    rospy.init_node(f"soak_{arguments.role}_{arguments.side}", anonymous=arguments.role == "late")
    notes.write("ready", arguments.role, arguments.run, 0)
    (talk if arguments.role == "talker" else listen)(arguments, notes)


if __name__ == "__main__":
    main()
