#!/usr/bin/env python3
"""Tests which changes of the code make a row of RESULTS.md old."""
import unittest

from results import digest

CODE = """// Adds.
double Sum(double a, double b) {
  return a + 2 * b;
}
"""


class DigestTest(unittest.TestCase):
    def is_same(self, changed):
        return digest(CODE, ".cpp") == digest(changed, ".cpp")

    def test_names_comments_and_layout_leave_it(self):
        self.assertTrue(self.is_same("/* Of two. */ double Total(double x, double y) { return x + 2 * y; }"))

    def test_a_number_a_sign_or_an_order_changes_it(self):
        for changed in (CODE.replace("2", "3"), CODE.replace("+", "-"), CODE.replace("a + 2 * b", "b + 2 * a")):
            self.assertFalse(self.is_same(changed), changed)

    def test_a_python_comment_leaves_it(self):
        self.assertEqual(digest("x = 1  # one\n", ".py"), digest("y = 1\n", ".py"))
        self.assertNotEqual(digest("x = 1\n", ".py"), digest("x = 2\n", ".py"))


if __name__ == "__main__":
    unittest.main()
