"""Stand-ins for messages that rosidl generates from the definitions below. They accept only these fields, with values
of these types."""
import re

DEFINITIONS = """
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
MSG: geometry_msgs/Wrench
geometry_msgs/Vector3 force
geometry_msgs/Vector3 torque
MSG: geometry_msgs/WrenchStamped
std_msgs/Header header
geometry_msgs/Wrench wrench
MSG: palpate_msgs/ContactWrench
std_msgs/Header header
geometry_msgs/Wrench wrench
float64 sigma
uint8 validity
uint8 acts_on
string check
MSG: diagnostic_msgs/KeyValue
string key
string value
MSG: diagnostic_msgs/DiagnosticStatus
byte level
string name
string message
string hardware_id
diagnostic_msgs/KeyValue[] values
MSG: diagnostic_msgs/DiagnosticArray
std_msgs/Header header
diagnostic_msgs/DiagnosticStatus[] status
"""
PRIMITIVES = {"float64": (float, lambda x: True), "string": (str, lambda x: True),
              "byte": (bytes, lambda x: len(x) == 1), "int32": (int, lambda x: -2**31 <= x < 2**31),
              "uint32": (int, lambda x: 0 <= x < 2**32), "uint8": (int, lambda x: 0 <= x < 2**8)}
FIELDS = {name: dict(reversed(line.split()) for line in body.strip().splitlines())
          for name, body in re.findall(r"MSG: (\S+)\n((?:(?!MSG:).*\n)+)", DEFINITIONS)}


class Message:
    def __init__(self, name):
        object.__setattr__(self, "_name", name)
        for field, kind in FIELDS[name].items():
            object.__setattr__(self, field, [] if kind.endswith("[]") else Message(kind) if kind in FIELDS
                               else PRIMITIVES[kind][0]())

    def __setattr__(self, field, value):
        kind = FIELDS[self._name].get(field)
        assert kind in PRIMITIVES, f"{self._name} has no field {field} to set"
        wanted, fits = PRIMITIVES[kind]
        assert type(value) is wanted and fits(value), f"{self._name}.{field}: {value!r} is no {kind}"
        object.__setattr__(self, field, value)

    def as_dict(self):
        return {field: plain(getattr(self, field)) for field in FIELDS[self._name]}


def plain(value):
    """Converts messages to dicts for JSON."""
    if isinstance(value, list):
        return [plain(each) for each in value]
    return value.as_dict() if isinstance(value, Message) else list(value) if isinstance(value, bytes) else value


class WrenchStamped(Message):
    def __init__(self):
        super().__init__("geometry_msgs/WrenchStamped")
