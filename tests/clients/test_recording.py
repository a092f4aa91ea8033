"""Reading of damaged, joined and incomplete recordings in Python. Needs the built Python client (PYTHONPATH)."""
import contextlib
import io
import pathlib
import struct
import sys
import tempfile
import unittest
import unittest.mock
import warnings
import zlib

try:
    import palpate
    from palpate import export
    from palpate.recording import attachments, messages
    from palpate.v1 import recording_pb2
except ImportError as missing:
    print(f"skipped: {missing}: deploy/install.sh tests")
    sys.exit(77)

MAGIC = b"\x89MCAP0\r\n"


# Builds records as specified in mcap.dev/spec.
def text(content):
    return struct.pack("<I", len(content)) + content.encode()


def record(opcode, content):
    return struct.pack("<BQ", opcode, len(content)) + content


def tick(number):
    message = recording_pb2.ForceTick()
    message.p_M.x = number
    content = message.SerializeToString()
    return record(5, struct.pack("<HIQQ", 1, number, 10**9 * number, 10**9 * number) + content)


def chunk(numbers):
    records = b"".join(tick(k) for k in numbers)
    return record(6, struct.pack("<QQQI", 10**9 * numbers[0], 10**9 * numbers[-1], len(records), zlib.crc32(records)) + text("") +
                  struct.pack("<Q", len(records)) + records)


def attached(name, content):
    head = struct.pack("<QQ", 0, 0) + text(name) + text("text/plain") + struct.pack("<Q", len(content)) + content
    return record(9, head + struct.pack("<I", zlib.crc32(head)))


def note(recording, number):
    entries = text("recording") + text(recording) + text("number") + text(str(number))
    return record(12, text("palpate.part") + struct.pack("<I", len(entries)) + entries)


def mcap(*chunks, before=b""):
    header = record(1, text("") + text("test"))
    channel = record(4, struct.pack("<HH", 1, 0) + text("/master/tick") + text("protobuf") + struct.pack("<I", 0))
    end = record(15, struct.pack("<I", 0)) + record(2, struct.pack("<QQI", 0, 0, 0))
    return MAGIC + header + before + channel + b"".join(chunks) + end + MAGIC


class RecordingTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.file = self.folder / "a.mcap"

    def read(self, content):
        """Returns the positions of the ticks and the damage, which must also cause a warning."""
        self.file.write_bytes(content)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            recording = palpate.read_recording(self.file)
        self.assertEqual([str(w.message) for w in caught], list(recording.damage))
        return [int(x) for x in recording.device[:, 0]], recording.damage

    def test_a_whole_recording_has_no_damage(self):
        self.assertEqual(self.read(mcap(chunk([1, 2]), chunk([3, 4]))), ([1, 2, 3, 4], ()))

    def test_a_chunk_with_a_wrong_checksum_is_left_out_and_its_place_is_named(self):
        whole = mcap(chunk([1, 2]), chunk([3, 4]), chunk([5]))
        at = whole.index(chunk([3, 4]))
        for place in (at + 60, at + len(chunk([3, 4])) - 1):
            damaged = bytearray(whole)
            damaged[place] ^= 0x10
            ticks, damage = self.read(bytes(damaged))
            self.assertEqual(ticks, [1, 2, 5])
            self.assertEqual(len(damage), 1, damage)
            self.assertIn(f"a.mcap: at byte {at}: a chunk of 1.000 s is damaged", damage[0])

    def test_a_cut_recording_is_read_to_the_cut(self):
        whole = mcap(chunk([1, 2]), chunk([3, 4]))
        ticks, damage = self.read(whole[:whole.index(chunk([3, 4])) + 50])
        self.assertEqual(ticks, [1, 2])
        self.assertIn("the last 50 bytes are incomplete", damage[0])
        ticks, damage = self.read(whole[:whole.index(chunk([3, 4]))])
        self.assertIn("never closed", damage[0])

    def test_what_follows_the_end_is_named(self):
        one = mcap(chunk([1, 2]))
        ticks, damage = self.read(one + mcap(chunk([3])))
        self.assertEqual(ticks, [1, 2])
        self.assertIn(f"a.mcap: at byte {len(one)}: another recording follows", damage[0])

    def test_parts_that_are_missing_or_of_another_recording_are_named(self):
        for name, identity, number, ticks in (("a-0001", "x", 1, [1]), ("a-0003", "x", 3, [3]), ("a-0004", "y", 4, [4])):
            (self.folder / f"{name}.mcap").write_bytes(mcap(chunk(ticks), before=note(identity, number)))
        with self.assertWarns(palpate.RecordingWarning):
            recording = palpate.read_recording(self.file)
        self.assertEqual(list(recording.device[:, 0]), [1, 3])
        self.assertIn("there is no part 2", recording.damage[0])
        self.assertIn("a-0004.mcap: is not a part of this recording", recording.damage[1])

    def test_attached_files_are_checked(self):
        whole = mcap(attached("scene.yaml", b"name: gel"))
        self.file.write_bytes(whole)
        self.assertEqual(attachments(self.file), {"scene.yaml": b"name: gel"})
        self.file.write_bytes(whole.replace(b"name: gel", b"name: gem"))
        with self.assertRaisesRegex(ValueError, "the attached file scene.yaml is damaged"):
            attachments(self.file)

    def test_files_of_other_programs_are_named(self):
        for content, expected in ((b"SQLite format 3\0" + bytes(100), "rosbag2"), (b"#ROSBAG V2.0\n", "a bag of ROS 1"),
                                  (b"\x28\xb5\x2f\xfd" + bytes(50), "zstd -d"), (b"t,x\n0,1\n", "no MCAP file")):
            self.file.write_bytes(content)
            with self.assertRaisesRegex(ValueError, expected):
                list(messages(self.file))

    def test_the_export_prints_damage_and_no_traceback(self):
        def run():
            printed = io.StringIO()
            with contextlib.redirect_stderr(printed), contextlib.redirect_stdout(printed), unittest.mock.patch.object(
                    sys, "argv", ["palpate.export", str(self.file), str(self.folder / "out")]):
                return export.main(), printed.getvalue()
        damaged = bytearray(mcap(chunk([1, 2]), chunk([3, 4])))
        damaged[damaged.index(chunk([3, 4])) + 80] ^= 1
        self.file.write_bytes(bytes(damaged))
        code, printed = run()
        self.assertEqual(code, 0)
        self.assertEqual(printed.count("a chunk of 1.000 s is damaged"), 1)
        self.assertIn("2 ticks", printed)
        # An invalid message in a chunk with a correct checksum.
        bad = record(5, struct.pack("<HIQQ", 1, 1, 0, 0) + b"\xff\xff\xff")
        self.file.write_bytes(mcap(bad))
        code, printed = run()
        self.assertEqual(code, 2)
        self.assertIn("a.mcap: a ForceTick is damaged", printed)


if __name__ == "__main__":
    unittest.main(verbosity=2)
