"""Stand-ins for the messages of diagnostic_msgs; see geometry_msgs."""
from geometry_msgs.msg import Message


class KeyValue(Message):
    def __init__(self):
        super().__init__("diagnostic_msgs/KeyValue")


class DiagnosticStatus(Message):
    OK, WARN, ERROR, STALE = b"\x00", b"\x01", b"\x02", b"\x03"

    def __init__(self):
        super().__init__("diagnostic_msgs/DiagnosticStatus")


class DiagnosticArray(Message):
    def __init__(self):
        super().__init__("diagnostic_msgs/DiagnosticArray")
