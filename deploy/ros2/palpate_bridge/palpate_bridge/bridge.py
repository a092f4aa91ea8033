#!/usr/bin/python3
"""Publishes the contact forces of a slave in ROS 2.

usage: bridge HOST:PORT [--topic NAME] [--frame NAME] [--rate HZ] [--messages N] [--tls DIR]

Needs rclpy, geometry_msgs and diagnostic_msgs of ROS 2, palpate_msgs beside this package, and the Python client (`pip install .`
in the repository).

- TOPIC (default palpate/wrench), geometry_msgs/WrenchStamped: wrench of the object on the tool, at the tip, in the frame
  --frame (default palpate_slave), frame S of the slave. The torque is NaN where the slave does not know the moment. Only
  valid forces are published, so a subscriber must watch their age.
- TOPIC/contact, palpate_msgs/ContactWrench: every new estimate and every change of its validity, with frame, sign, standard
  deviation and validity. Unknown numbers are NaN.
- /diagnostics, diagnostic_msgs/DiagnosticArray: validity, standard deviation and reason of every new estimate, and
  whether the moment is known. Unknown values are absent. It is published when the validity changes too, for example to
  stale, and at least once a second. The level is OK: valid; STALE: the sensor is silent, or the slave for one second;
  ERROR: no connection; else WARN.

The time of a message is that of the image or tactile sample, converted from the slave's clock to that of the node. All
topics are reliable and keep the newest 10, which serves best-effort subscribers, too. After a lost connection the bridge
connects again. --messages: end after N wrenches; default: never. Prints the number of wrenches. Exit code 0: all were published;
1: the node was stopped before.
"""
import argparse
import collections
import math
import sys
import threading
import time

import grpc
import palpate
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import WrenchStamped
from palpate.v1 import teleoperation_pb2
from palpate_msgs.msg import ContactWrench

KEPT = 10    # messages of a reliable topic
AGAIN = 1.0  # [s] between two measurements of the clock, diagnostics of a silent sensor, and attempts to connect


class SlaveClock:
    """Converts times from the slave's clock to that of the node. The slave's clock drifts, so its offset is measured
    again every second.

    The reply with the shortest round trip is the most certain: its time is that of the middle of the trip.
    """

    def __init__(self, slave: palpate.Slave, node) -> None:
        self._slave, self._node = slave, node
        self._replies = collections.deque(maxlen=5)  # (round trip, offset) [ns]
        self._due, self._offset, self._waits = 0.0, 0, False
        for _ in range(5):
            self._take(self._now(), slave.status())

    def local(self, instant) -> int:
        """The node's time [ns since 1970] at a timestamp of the slave."""
        if time.monotonic() > self._due and not self._waits:
            self._waits, before = True, self._now()
            future = self._slave.stub.GetStatus.future(teleoperation_pb2.GetStatusRequest(), timeout=10)
            future.add_done_callback(
                lambda reply: self._take(before, reply.result() if reply.code() == grpc.StatusCode.OK else None))
        return int(instant.ToNanoseconds()) + self._offset

    def _now(self) -> int:
        return self._node.get_clock().now().nanoseconds

    def _take(self, before: int, status) -> None:
        after = self._now()
        if status is not None:
            self._replies.append((after - before, (before + after) // 2 - status.now.ToNanoseconds()))
            self._offset = min(self._replies)[1]
        self._due, self._waits = time.monotonic() + AGAIN, False


def set_stamp(header, nanoseconds: int) -> None:
    header.stamp.sec, header.stamp.nanosec = divmod(nanoseconds, 10**9)


def is_known(vector) -> bool:
    return all(map(math.isfinite, vector))


def set_wrench(wrench, state: palpate.State) -> None:
    force, torque = wrench.force, wrench.torque
    force.x, force.y, force.z = (float(x) for x in state.force)
    torque.x, torque.y, torque.z = (float(x) for x in state.moment)


def wrench(state: palpate.State) -> WrenchStamped:
    """The message of one valid state, without its header."""
    message = WrenchStamped()
    set_wrench(message.wrench, state)
    return message


def contact_wrench(state: palpate.State) -> ContactWrench:
    """The message of one state, without its header."""
    message = ContactWrench()
    set_wrench(message.wrench, state)
    message.sigma = float(state.sigma)
    message.validity = int(state.validity)
    message.acts_on = ContactWrench.ON_TOOL
    message.check = state.check or ""
    return message


def diagnostics(level: bytes, words: str, frame: str, values: dict[str, str]) -> DiagnosticArray:
    """The message without its time."""
    status = DiagnosticStatus()
    status.name, status.hardware_id, status.level, status.message = "palpate: contact force", frame, level, words
    for key, value in values.items():
        pair = KeyValue()
        pair.key, pair.value = key, value
        status.values.append(pair)
    message = DiagnosticArray()
    message.status.append(status)
    return message


def diagnostics_of(state: palpate.State, frame: str) -> DiagnosticArray:
    """Validity and standard deviation of one state."""
    level = {palpate.Validity.VALID: DiagnosticStatus.OK, palpate.Validity.STALE: DiagnosticStatus.STALE}
    values = {"validity": state.validity.name.lower(), "moment known": str(is_known(state.moment))}
    if math.isfinite(state.sigma):
        values["sigma [N]"] = f"{state.sigma:.6g}"
    words = "valid" if state.valid else state.check or state.validity.name.lower()
    return diagnostics(level.get(state.validity, DiagnosticStatus.WARN), words, frame, values)


class Bridge:
    """Publishes the states of a slave."""

    def __init__(self, arguments: argparse.Namespace, node) -> None:
        self._arguments, self._node = arguments, node
        self._wrenches = node.create_publisher(WrenchStamped, arguments.topic, KEPT)
        self._contacts = node.create_publisher(ContactWrench, f"{arguments.topic}/contact", KEPT)
        self._diagnostics = node.create_publisher(DiagnosticArray, "/diagnostics", KEPT)
        self._came = math.inf  # [s] when the last state came; infinite: not connected
        self.published = 0  # wrenches

    def is_done(self) -> bool:
        return self.published == self._arguments.messages > 0 or not rclpy.ok()

    def run(self) -> None:
        """Reconnects until enough messages are published."""
        ends = threading.Event()
        watching = threading.Thread(target=self._watch, args=(ends,))
        watching.start()
        try:
            while not self.is_done():
                try:
                    with palpate.connect(self._arguments.target, self._arguments.tls) as slave:
                        self._publish(slave)
                except palpate.Error as error:
                    self._came = math.inf
                    self._report(DiagnosticStatus.ERROR, f"no connection: {error}")
                    print(f"bridge: {error}", file=sys.stderr, flush=True)
                    time.sleep(AGAIN)
        finally:
            ends.set()
            watching.join()

    def _watch(self, ends: threading.Event) -> None:
        """Reports a silent slave: a line that is cut ends a connection only after many seconds."""
        reported = 0.0
        while not ends.wait(AGAIN / 10):
            now = time.monotonic()
            if now - self._came > AGAIN and now - reported > AGAIN:
                self._report(DiagnosticStatus.STALE, f"no state for {now - self._came:.0f} s")
                reported = now

    def _report(self, level: bytes, words: str) -> None:
        message = diagnostics(level, words, self._arguments.frame, {})
        set_stamp(message.header, self._node.get_clock().now().nanoseconds)
        self._diagnostics.publish(message)

    def _publish(self, slave: palpate.Slave) -> None:
        clock, last, due = SlaveClock(slave, self._node), None, 0.0
        for state in slave.states(self._arguments.rate, details=True):
            self._came = time.monotonic()
            now = state.t, state.validity, state.check
            is_new = last is None or now[0] != last[0]  # states are repeated between two samples
            sensed = clock.local(state.message.sensed_at)
            if now != last or time.monotonic() > due:
                message = diagnostics_of(state, self._arguments.frame)
                set_stamp(message.header, sensed)
                self._diagnostics.publish(message)
                due = time.monotonic() + AGAIN
            if now != last:
                self._send(self._contacts, contact_wrench(state), sensed)
            if is_new and state.valid and is_known(state.force):
                self._send(self._wrenches, wrench(state), sensed)
                self.published += 1
            last = now
            if self.is_done():
                break

    def _send(self, publisher, message, sensed: int) -> None:
        message.header.frame_id = self._arguments.frame
        set_stamp(message.header, sensed)
        publisher.publish(message)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", help="HOST:PORT")
    parser.add_argument("--topic", default="palpate/wrench")
    parser.add_argument("--frame", default="palpate_slave")
    parser.add_argument("--rate", type=float, default=0)
    parser.add_argument("--messages", type=int, default=0)
    parser.add_argument("--tls", metavar="DIR", help="folder with ca.pem, cert.pem and key.pem")
    arguments = parser.parse_args(rclpy.utilities.remove_ros_args(sys.argv)[1:])
    rclpy.init(args=sys.argv)
    node = rclpy.create_node("palpate_bridge")
    bridge = Bridge(arguments, node)
    try:
        bridge.run()
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    print(f"{bridge.published} wrenches published on {arguments.topic}")
    return 0 if bridge.published == arguments.messages or not arguments.messages else 1


if __name__ == "__main__":
    sys.exit(main())
