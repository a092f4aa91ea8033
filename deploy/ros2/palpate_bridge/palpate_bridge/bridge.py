#!/usr/bin/python3
"""Publishes the contact forces of a slave in ROS 2.

usage: bridge HOST:PORT [--topic NAME] [--frame NAME] [--rate HZ] [--messages N] [--tls DIR]

Needs rclpy, geometry_msgs and diagnostic_msgs of ROS 2, and the Python client (`pip install .` in the repository).

- TOPIC (default palpate/wrench), geometry_msgs/WrenchStamped: wrench of the object on the tool, at the tip, in the frame
  --frame (default palpate_slave), frame S of the slave. Its time is that of the image or tactile sample. The torque is 0
  where the slave does not know the moment. Only valid forces are published, so a subscriber must watch their age.
- /diagnostics, diagnostic_msgs/DiagnosticArray: validity, standard deviation and reason of every new estimate, and
  whether the moment is known. Unknown values are absent.

Both have the quality of service of sensor data: best effort, the newest 5. --messages: end after N wrenches; default: never.
Prints the number of wrenches. Exit code 0: all were published; 1: the slave ended before.
"""
import argparse
import math
import sys

import palpate
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import WrenchStamped
from rclpy.qos import qos_profile_sensor_data


def stamp(header, state: palpate.State) -> None:
    sensed = state.message.sensed_at
    header.stamp.sec, header.stamp.nanosec = sensed.seconds, sensed.nanos


def wrench(state: palpate.State, frame: str) -> WrenchStamped:
    """The message of one valid state."""
    message = WrenchStamped()
    message.header.frame_id = frame
    stamp(message.header, state)
    force, torque = message.wrench.force, message.wrench.torque
    force.x, force.y, force.z = (float(x) for x in state.force)
    if all(map(math.isfinite, state.moment)):
        torque.x, torque.y, torque.z = (float(x) for x in state.moment)
    return message


def diagnostics(state: palpate.State, frame: str) -> DiagnosticArray:
    """Validity and standard deviation of one state."""
    status = DiagnosticStatus()
    status.name, status.hardware_id = "palpate: contact force", frame
    status.level = DiagnosticStatus.OK if state.valid else DiagnosticStatus.WARN
    status.message = "valid" if state.valid else state.check or state.validity.name.lower()
    values = {"validity": state.validity.name.lower(), "moment known": str(all(map(math.isfinite, state.moment)))}
    if math.isfinite(state.sigma):
        values["sigma [N]"] = f"{state.sigma:.6g}"
    for key, value in values.items():
        pair = KeyValue()
        pair.key, pair.value = key, value
        status.values.append(pair)
    message = DiagnosticArray()
    stamp(message.header, state)
    message.status.append(status)
    return message


def publish(arguments: argparse.Namespace, node) -> int:
    """Until the slave ends or enough is published; the number of wrenches."""
    wrenches = node.create_publisher(WrenchStamped, arguments.topic, qos_profile_sensor_data)
    states = node.create_publisher(DiagnosticArray, "/diagnostics", qos_profile_sensor_data)
    published, last = 0, 0.0
    with palpate.connect(arguments.target, arguments.tls) as slave:
        for state in slave.states(arguments.rate, details=True):
            if state.t > last:  # states are repeated between two samples
                last = state.t
                states.publish(diagnostics(state, arguments.frame))
                if state.valid and all(map(math.isfinite, state.force)):
                    wrenches.publish(wrench(state, arguments.frame))
                    published += 1
            if published == arguments.messages > 0 or not rclpy.ok():
                break
    return published


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
    try:
        published = publish(arguments, node)
    except palpate.Error as error:
        sys.exit(f"error: {error}")
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    print(f"{published} wrenches published on {arguments.topic}")
    return 0 if published == arguments.messages or not arguments.messages else 1


if __name__ == "__main__":
    sys.exit(main())
