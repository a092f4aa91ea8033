"""The message of deploy/ros2/palpate_msgs. Its fields are those of the definition there."""
from geometry_msgs.msg import Message


class ContactWrench(Message):
    ON_TOOL, ON_OBJECT = 1, 2

    def __init__(self):
        super().__init__("palpate_msgs/ContactWrench")
