"""Stand-in for the message of deploy/ros2/palpate_msgs, with the fields of its definition."""
from geometry_msgs.msg import Message


class ContactWrench(Message):
    ON_TOOL, ON_OBJECT = 1, 2

    def __init__(self):
        super().__init__("palpate_msgs/ContactWrench")
