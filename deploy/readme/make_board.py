#!/usr/bin/env python3
"""Writes deploy/guides/board.pdf, an A4 page to print: two chessboards of 9 x 6 inner corners, and a ruler. Lengths in mm."""
import pathlib

FILE = pathlib.Path(__file__).resolve().parents[1] / "guides/board.pdf"
PAGE = (210, 297)
SQUARES = (10, 7)
RULER = 150
POINTS = 72 / 25.4  # per mm


def box(x, y, width, height):
    return f"{x:g} {y:g} {width:g} {height:g} re f"


def text(x, y, words, size=3.5):
    return f"BT /F {size:g} Tf {x:g} {y:g} Td ({words}) Tj ET"


def board(x, y, square):
    """Draws a chessboard with its lower left corner at (x, y)."""
    squares = [(i, j) for j in range(SQUARES[1]) for i in range(SQUARES[0]) if (i + j) % 2 == 0]
    inner = f"{SQUARES[0] - 1} and {SQUARES[1] - 1} inner corners, edge of a square {square:g} mm"
    return [box(x + square * i, y + square * j, square, square) for i, j in squares] + [text(x, y - 6, inner)]


def ruler(x, y):
    marks = []
    for i in range(RULER + 1):
        tall = 8 if i % 10 == 0 else 6 if i % 5 == 0 else 4
        marks.append(box(x + i - 0.1, y, 0.2, tall))
        if i % 10 == 0:
            marks.append(text(x + i - 1.2, y + 9, str(i), 3))
    return [box(x - 0.1, y, RULER + 0.2, 0.3), *marks, text(x, y - 6, "mm")]


def content():
    head = [text(30, 275, "Print at 100 %, without \"fit to page\". Then measure the ruler: it must be 150 mm long."),
            text(30, 269, "Cut out the ruler or one board, and fix it flat in the plane of the object.")]
    lines = [f"{POINTS:.6f} 0 0 {POINTS:.6f} 0 0 cm", *head, *ruler(30, 240), *board(30, 140, 10), *board(30, 80, 5)]
    return "\n".join(lines).encode()


def pdf(stream):
    size = " ".join(f"{POINTS * side:.2f}" for side in PAGE)
    objects = [b"<< /Type /Catalog /Pages 2 0 R >>", b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
               f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {size}] /Contents 4 0 R /Resources << /Font << /F 5 0 R >> >> >>".encode(),
               b"<< /Length %d >>\nstream\n%s\nendstream" % (len(stream), stream),
               b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>"]
    out, places = b"%PDF-1.4\n", []
    for number, body in enumerate(objects, 1):
        places.append(len(out))
        out += b"%d 0 obj\n%s\nendobj\n" % (number, body)
    table = "".join(f"{place:010d} 00000 n \n" for place in places).encode()
    return out + b"xref\n0 %d\n0000000000 65535 f \n%strailer\n<< /Size %d /Root 1 0 R >>\nstartxref\n%d\n%%%%EOF\n" % (
        len(objects) + 1, table, len(objects) + 1, len(out))


FILE.write_bytes(pdf(content()))
print(FILE.name, FILE.stat().st_size, "bytes")
