#!/usr/bin/python3
"""Bridge to ROS 2: publishes the valid forces of a slave as geometry_msgs/WrenchStamped.

usage: ros2_bridge.py HOST:PORT [--topic NAME] [--frame NAME] [--rate HZ] [--messages N] [--tls DIR]

Needs rclpy and geometry_msgs of ROS 2. The wrench is that of the object on the tool, in frame S of the slave, at the
tip. Its time is that of the image or tactile sample. The torque is NaN where the slave does not know the moment. Nothing is
published while the force is not valid, so a subscriber must watch the age of the messages.
--topic: default palpate/wrench. --frame: frame_id, default palpate_slave. --messages: end after N; default: never.

Prints the number of messages. Exit code 0: all were published; 1: the slave ended before.
"""
import argparse
import sys

import palpate
import rclpy
from geometry_msgs.msg import WrenchStamped


def wrench(state: palpate.State, frame: str) -> WrenchStamped:
    """The message of one state."""
    message = WrenchStamped()
    message.header.frame_id = frame
    sensed = state.message.sensed_at
    message.header.stamp.sec, message.header.stamp.nanosec = sensed.seconds, sensed.nanos
    force, torque = message.wrench.force, message.wrench.torque
    force.x, force.y, force.z = (float(x) for x in state.force)
    torque.x, torque.y, torque.z = (float(x) for x in state.moment)
    return message


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("target", help="HOST:PORT")
    parser.add_argument("--topic", default="palpate/wrench")
    parser.add_argument("--frame", default="palpate_slave")
    parser.add_argument("--rate", type=float, default=0)
    parser.add_argument("--messages", type=int, default=0)
    parser.add_argument("--tls", metavar="DIR", help="folder with ca.pem, cert.pem and key.pem")
    arguments = parser.parse_args()
    rclpy.init()
    node = rclpy.create_node("palpate_bridge")
    publisher = node.create_publisher(WrenchStamped, arguments.topic, 10)
    published, last = 0, 0.0
    with palpate.connect(arguments.target, arguments.tls) as slave:
        for state in slave.states(arguments.rate, details=True):
            if state.valid and state.t > last:  # states are repeated between two samples
                publisher.publish(wrench(state, arguments.frame))
                published, last = published + 1, state.t
            if published == arguments.messages > 0 or not rclpy.ok():
                break
    node.destroy_node()
    rclpy.try_shutdown()
    print(f"{published} wrenches published on {arguments.topic}")
    return 0 if published == arguments.messages or not arguments.messages else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except palpate.Error as error:
        sys.exit(f"error: {error}")
