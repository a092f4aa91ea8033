#!/usr/bin/env python3
"""Makes frames.svg: the frames M, S, O and F and the camera, and the direction of each reported force."""
import pathlib

HERE = pathlib.Path(__file__).resolve().parent
X, Y, Z, INK, FORCE, FILL = "#c92a2a", "#2b8a3e", "#1864ab", "#333", "#d9480f", "#e9ecef"


def arrow(x, y, dx, dy, colour, text="", width=2):
    marks = {X: "x", Y: "y", Z: "z", FORCE: "f"}
    length = (dx * dx + dy * dy) ** 0.5
    tx, ty = x + dx + 12 * dx / length, y + dy + 12 * dy / length + 4
    return (f'<line x1="{x}" y1="{y}" x2="{x + dx}" y2="{y + dy}" stroke="{colour}" stroke-width="{width}" '
            f'marker-end="url(#{marks[colour]})"/><text x="{tx:.0f}" y="{ty:.0f}" fill="{colour}" '
            f'text-anchor="middle">{text}</text>')


def towards_viewer(x, y, text):
    return (f'<circle cx="{x}" cy="{y}" r="6" fill="#fff" stroke="{Z}" stroke-width="2"/>'
            f'<circle cx="{x}" cy="{y}" r="2" fill="{Z}"/><text x="{x - 16}" y="{y + 18}" fill="{Z}">{text}</text>')


def label(x, y, text, colour=INK, anchor="start", bold=False):
    weight = ' font-weight="bold"' if bold else ""
    return f'<text x="{x}" y="{y}" fill="{colour}" text-anchor="{anchor}"{weight}>{text}</text>'


def device():
    return [label(20, 30, "M: device, as the operator faces it", bold=True),
            '<path d="M60 190 q60 -90 130 -40" fill="none" stroke="#868e96" stroke-width="8"/>',
            '<circle cx="190" cy="150" r="9" fill="#868e96"/>',
            arrow(100, 270, 50, 0, X, "x"), arrow(100, 270, 0, -50, Y, "y"), towards_viewer(100, 270, "z"),
            label(125, 296, "z: towards the operator"),
            arrow(190, 150, 0, -55, FORCE, "", 3), label(206, 106, "force on the operator", FORCE)]


def block():
    return [label(380, 30, "S and O: one camera, block (S = O here)", bold=True),
            f'<rect x="440" y="150" width="150" height="120" fill="{FILL}" stroke="#868e96"/>',
            '<line x1="432" y1="271" x2="598" y2="271" stroke="#333" stroke-width="4"/>', label(515, 292, "fixed", anchor="middle"),
            '<rect x="503" y="72" width="24" height="86" fill="#adb5bd" stroke="#868e96"/>', label(495, 92, "tool", anchor="end"),
            arrow(440, 270, 55, 0, X, "x"), arrow(440, 270, 0, -55, Y, "y"), towards_viewer(440, 270, "z"),
            arrow(515, 158, 0, -62, FORCE, "", 3), label(534, 112, "state.force (+y):", FORCE),
            label(534, 128, "object on tool", FORCE),
            arrow(552, 150, 0, 48, FORCE, "", 3), label(605, 176, "solve, press (-y):", FORCE), label(605, 192, "tool on object", FORCE),
            label(380, 314, "camera looks along -z; pose: image centre, x right, y up")]


def camera():
    return [label(20, 350, "Left or depth camera", bold=True),
            '<rect x="70" y="420" width="46" height="34" fill="#adb5bd" stroke="#868e96"/>',
            arrow(116, 437, 80, 0, Z, "z"), arrow(116, 437, 0, 55, Y, "y"),
            f'<circle cx="116" cy="437" r="6" fill="#fff" stroke="{X}" stroke-width="2"/>'
            f'<circle cx="116" cy="437" r="2" fill="{X}"/>', label(80, 412, "x: towards you", X),
            label(20, 530, "z forward, x right, y down in the image"), label(20, 548, "pose: projection centre in S")]


def fingertip():
    return [label(380, 350, "F: fingertip, seen from its side", bold=True),
            '<path d="M370 410 h110 a34 34 0 0 1 0 68 h-110 z" fill="#adb5bd" stroke="#868e96"/>',
            f'<rect x="400" y="482" width="190" height="34" fill="{FILL}" stroke="#868e96"/>', label(530, 504, "object"),
            arrow(480, 444, 65, 0, X, "x"), arrow(480, 444, 0, -60, Z, "z"),
            f'<circle cx="480" cy="444" r="5" fill="#fff" stroke="{Y}" stroke-width="2"/>'
            f'<path d="M477 441 l6 6 m0 -6 l-6 6" stroke="{Y}"/>', label(488, 462, "y: away from you", Y),
            arrow(430, 478, 0, 48, FORCE, "", 3), label(400, 548, "palpate.train: fingertip on object (press: fz below 0)", FORCE),
            label(520, 398, "pad towards -z, tip towards +x")]


def main():
    markers = "".join(f'<marker id="{name}" viewBox="0 0 10 10" refX="8" refY="5" markerWidth="5" markerHeight="5" '
                      f'orient="auto"><path d="M0 0 L10 5 L0 10 z" fill="{colour}"/></marker>'
                      for name, colour in {"x": X, "y": Y, "z": Z, "f": FORCE}.items())
    svg = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 800 570" font-family="sans-serif" font-size="13">',
           "<title>Frames M, S, O, F and camera, and the directions of forces</title>",
           f'<defs>{markers}</defs><rect width="800" height="570" fill="#fff"/>',
           *device(), *block(), *camera(), *fingertip(), "</svg>"]
    (HERE / "frames.svg").write_text("\n".join(svg) + "\n", encoding="utf-8")
    print(HERE / "frames.svg")


if __name__ == "__main__":
    main()
