"""Writes bags with wrenches as ROS 2 does: MCAP files and databases of rosbag2."""
import sqlite3
import struct

STAMPED, PLAIN, CONTACT = "geometry_msgs/msg/WrenchStamped", "geometry_msgs/msg/Wrench", "palpate_msgs/msg/ContactWrench"
MAGIC = b"\x89MCAP0\r\n"


def wrench(kind, t_ns, force, sigma=None, validity=1, frame="sensor", order="<", acts_on=1):
    """Encodes a message in CDR (OMG DDS-XTYPES 7.4: each value is aligned to its size behind the header of four
    bytes)."""
    body = bytearray()

    def put(code, value):
        size = struct.calcsize(code)
        body.extend(bytes(-len(body) % size) + struct.pack(order + code, value))

    def put_text(text):
        data = text.encode() + b"\0"
        put("I", len(data))
        body.extend(data)

    if kind != PLAIN:
        put("i", t_ns // 10**9)
        put("I", t_ns % 10**9)
        put_text(frame)
    for number in (*force, 0.0, 0.0, 0.0):
        put("d", number)
    if kind == CONTACT:
        put("d", sigma)
        put("B", validity)
        put("B", acts_on)
        put_text("")
    return (b"\0\1\0\0" if order == "<" else b"\0\0\0\0") + bytes(body)


def _record(opcode, content):
    return struct.pack("<BQ", opcode, len(content)) + content


def _text(content):
    return struct.pack("<I", len(content)) + content.encode()


def write_mcap(file, messages, encoding="cdr", chunked=True):
    """Writes an MCAP file (mcap.dev/spec). `messages`: (topic, kind, t_ns, data)."""
    topics = {topic: (number, kind) for number, (topic, kind) in enumerate(dict((m[0], m[1]) for m in messages).items(), 1)}
    inside = b""
    for topic, (number, kind) in topics.items():
        inside += _record(3, struct.pack("<H", number) + _text(kind) + _text("ros2msg") + struct.pack("<I", 0))
        inside += _record(4, struct.pack("<HH", number, number) + _text(topic) + _text(encoding) + struct.pack("<I", 0))
    for i, (topic, _, t_ns, data) in enumerate(messages):
        inside += _record(5, struct.pack("<HIQQ", topics[topic][0], i, t_ns, t_ns) + data)
    if chunked:
        times = [m[2] for m in messages]
        inside = _record(6, struct.pack("<QQQI", min(times), max(times), len(inside), 0) + _text("") + struct.pack("<Q", len(inside)) + inside)
    file.write_bytes(MAGIC + _record(1, _text("ros2") + _text("")) + inside + _record(15, struct.pack("<I", 0)) +
                     _record(2, struct.pack("<QQI", 0, 0, 0)) + MAGIC)


def write_db3(file, messages):
    """Writes the tables of rosbag2_storage_sqlite3. `messages`: as for write_mcap."""
    with sqlite3.connect(file) as database:
        database.executescript("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT "
                               "NOT NULL, offered_qos_profiles TEXT NOT NULL); CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER "
                               "NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);")
        numbers = {}
        for topic, kind, t_ns, data in messages:
            if topic not in numbers:
                numbers[topic] = database.execute("INSERT INTO topics(name, type, serialization_format, offered_qos_profiles) VALUES (?, ?, "
                                                  "'cdr', '')", (topic, kind)).lastrowid
            database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", (numbers[topic], t_ns, data))
    database.close()
