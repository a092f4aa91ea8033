"""Renders images of a webcam in front of a pressed body: a pinhole camera with uncorrected distortion, a background, a
support, a ruler, a hand with its shadow, uneven light, drift of the exposure, noise and JPEG. The code is independent
of the product.

Lengths in mm in the frame of bodies.py; images in pixels, (0, 0) at the centre of the upper left one.
"""
import io

import numpy as np
from PIL import Image, ImageDraw, ImageFilter

FINE = 6  # samples per pixel in each direction; straight edges lie on whole samples
QUALITY = 88  # quality of JPEG


class Camera:
    """A pinhole camera at `at` that looks along -z, rotated by small `turns` about x, y and z [rad]. `focal` is in px,
    `k1` is the radial distortion."""

    def __init__(self, at, focal, size, turns=(0, 0, 0), k1=0.0):
        self.at, self.focal, self.size, self.k1 = np.asarray(at, float), focal, size, k1
        (sx, cx), (sy, cy), (sz, cz) = [(np.sin(turn), np.cos(turn)) for turn in turns]
        self.turn = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]]) @ np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]]) @ \
            np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])

    def project(self, points):
        p = (np.atleast_2d(np.asarray(points, float)) - self.at) @ self.turn.T
        x, y = p[:, 0] / -p[:, 2], p[:, 1] / -p[:, 2]
        half = self.size[0] / 2 / self.focal
        bent = 1 + self.k1 * (x * x + y * y) / half ** 2 / 4
        return np.stack([(self.size[0] - 1) / 2 + self.focal * x * bent, (self.size[1] - 1) / 2 - self.focal * y * bent], 1)

    def pixel(self):
        """Returns the edge of a pixel in the plane z = 0 [mm]."""
        return self.at[2] / self.focal


def at_depth(points, z):
    points = np.atleast_2d(np.asarray(points, float))
    return np.concatenate([points, np.full((len(points), 1), float(z))], 1)


def finer(points, longest=3.0):
    """Returns a closed polygon with points at least every `longest`, so that the distortion bends its sides."""
    points = np.asarray(points, float)
    parts = []
    for a, b in zip(points, np.roll(points, -1, 0)):
        count = max(1, int(np.ceil(np.hypot(*(b - a)[:2]) / longest)))
        parts.append(a + (b - a) * (np.arange(count) / count)[:, None])
    return np.concatenate(parts)


def noise_field(rng, shape, slope):
    """Returns a random field of standard deviation 1 whose amplitude falls with frequency^slope, as in photographs."""
    fy, fx = np.fft.fftfreq(shape[0])[:, None], np.fft.rfftfreq(shape[1])[None]
    away = np.maximum(np.hypot(fy, fx), 1 / max(shape))
    field = np.fft.irfft2(np.fft.rfft2(rng.normal(size=shape)) / away ** slope, shape)
    return (field - field.mean()) / field.std()


def background(kind, rng, size, level):
    """Returns an image [height, width, 3] of 0 to 255: a `wall`, `clutter` on a table, or a `photo`."""
    width, height = size
    tint = level * (1 + 0.06 * rng.normal(size=3))
    if kind == "wall":
        return np.clip(tint + 2 * noise_field(rng, (height, width), 0.6)[..., None], 0, 255)
    if kind == "photo":
        image = np.stack([noise_field(rng, (height, width), 1.1) for _ in range(3)], -1)
        image = level + 26 * (0.7 * image[..., :1] + 0.3 * image)
    else:
        image = np.broadcast_to(tint, (height, width, 3)).copy()
    canvas = Image.fromarray(np.clip(image, 0, 255).astype(np.uint8))
    pen = ImageDraw.Draw(canvas)
    for _ in range(14 if kind == "clutter" else 5):
        x, y = rng.uniform(0, width), rng.uniform(0, height)
        w, h = rng.uniform(0.03, 0.16, 2) * width
        colour = tuple(int(v) for v in np.clip(level + rng.normal(0, 55) + rng.normal(0, 18, 3), 5, 250))
        if rng.random() < 0.5:
            pen.ellipse([x - w, y - h, x + w, y + h], fill=colour)
        else:
            turn = rng.uniform(0, np.pi)
            c, s = np.cos(turn), np.sin(turn)
            pen.polygon([(x + c * a - s * b, y + s * a + c * b) for a, b in ((-w, -h), (w, -h), (w, h), (-w, h))], fill=colour)
    return np.asarray(canvas.filter(ImageFilter.GaussianBlur(1.2 if kind == "photo" else 0.8)), float)


def paint(canvas, points, colour):
    """Fills a polygon in fine pixels by the even-odd rule: a pixel belongs to it if its centre does."""
    x, y = np.asarray(points, float).T - 0.5
    x1, y1 = np.roll(x, -1), np.roll(y, -1)
    low, high = np.ceil(np.minimum(y, y1)).astype(int), np.ceil(np.maximum(y, y1)).astype(int)
    low, high = np.clip(low, 0, canvas.shape[0]), np.clip(high, 0, canvas.shape[0])
    count = high - low
    if not count.any():
        return
    side = np.repeat(np.arange(len(x)), count)
    row = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + low[side]
    at = x[side] + (row - y[side]) * (x1 - x)[side] / (y1 - y)[side]
    column = np.clip(np.ceil(at), 0, canvas.shape[1]).astype(int)
    top, bottom, left, right = row.min(), row.max() + 1, column.min(), column.max() + 1
    crossings = np.zeros((bottom - top, right - left), np.uint8)
    np.add.at(crossings, (row - top, column - left), 1)
    inside = np.add.accumulate(crossings, 1, dtype=np.uint8) % 2 == 1
    canvas[top:bottom, left:right][inside[:, :canvas.shape[1] - left]] = np.clip(np.round(colour), 0, 255)


class Stage:
    """The constant parts of a scene. `image` draws one instant. `setup` is a set-up of setups.py."""

    def __init__(self, setup, rng):
        self.setup, self.rng, self.camera = setup, rng, setup.camera
        width, height = self.camera.size
        fill = background(setup.background, rng, (width, height), setup.wall)
        base = np.array(Image.fromarray(fill.astype(np.uint8)).resize((FINE * width, FINE * height), Image.BILINEAR))
        for points, colour in setup.support():
            self.fill(base, points, colour)
        for points, colour in setup.ruler():
            self.fill(base, points, colour)
        self.base = base
        v, u = np.mgrid[:height, :width]
        x, y = (u - width / 2) / (width / 2), (v - height / 2) / (width / 2)
        light = 1 + setup.light[0] * x + setup.light[1] * y
        self.light = light * (1 - 0.1 * (x * x + y * y)) * (1 + 0.008 * noise_field(rng, (height, width), 1.2))

    def fill(self, canvas, points, colour):
        paint(canvas, (self.camera.project(finer(points)) + 0.5) * FINE, colour)

    def prism(self, canvas, outline, front, back, colour, side):
        """Draws a body with equal front and rear outlines: its far face, its sides, then its near face."""
        far, near = at_depth(outline, back), at_depth(outline, front)
        self.fill(canvas, far, side)
        self.sides(canvas, near, far, side)
        self.fill(canvas, near, colour)

    def image(self, tip, outline, gain=1.0):
        """Draws an image as JPEG for the tool's tip [x, y], the body's outline, and the gain of the exposure."""
        setup, canvas = self.setup, self.base.copy()
        side = 0.82 * np.asarray(setup.colour)
        front, back = setup.tool_span()
        if front > 0:  # the tool reaches through the whole thickness
            self.prism(canvas, outline, 0, -setup.thickness, setup.colour, side)
            self.tool(canvas, tip, front, back)
        else:
            far, near = at_depth(outline, -setup.thickness), at_depth(outline, 0)
            self.fill(canvas, far, side)
            self.sides(canvas, near, far, side)
            self.tool(canvas, tip, front, back)
            self.fill(canvas, near, setup.colour)
        self.hand(canvas, tip)
        image = np.asarray(Image.fromarray(canvas).reduce(FINE), float)
        image = np.asarray(Image.fromarray(image.astype(np.uint8)).filter(ImageFilter.GaussianBlur(setup.blur)), float)
        image = image * (self.light * self.shade(tip) * gain)[..., None]
        image += setup.noise * self.rng.standard_normal(image.shape, np.float32)
        coded = io.BytesIO()
        Image.fromarray(np.clip(image + 0.5, 0, 255).astype(np.uint8)).save(coded, "JPEG", quality=QUALITY)
        return coded.getvalue()

    def sides(self, canvas, near, far, colour):
        near, far = (self.camera.project(points) for points in (near, far))
        for a, b, c, d in zip(near, np.roll(near, -1, 0), np.roll(far, -1, 0), far):
            paint(canvas, (np.array([a, b, c, d]) + 0.5) * FINE, colour)

    def tool(self, canvas, tip, front, back):
        setup = self.setup
        tool, tip = setup.tool, np.asarray(tip, float)
        aside = np.linspace(-tool.half, tool.half, 25)
        recess = tool.recess(aside * (1 - 1e-9))
        def place(s, a):
            return tip + np.multiply.outer(s, tool.across) - np.multiply.outer(a, tool.direction)
        end = place(aside, 0) - recess[:, None] * tool.direction
        whole = np.concatenate([end, place(np.array([tool.half, -tool.half]), setup.tool_length)])
        self.prism(canvas, whole, front, back, setup.tool_colour, 0.8 * np.asarray(setup.tool_colour))
        for low, high, colour in setup.bands:
            corners = np.array([place(s, a) for s, a in ((-tool.half, low), (tool.half, low), (tool.half, high), (-tool.half, high))])
            self.fill(canvas, at_depth(corners, front), colour)

    def hand(self, canvas, tip):
        setup = self.setup
        away = np.asarray(tip, float) - setup.grip * setup.tool.direction
        angle = np.linspace(0, 2 * np.pi, 40)
        for x, y, a, b, tone in ((3, 4, 17, 13, 1.0), (12, 16, 26, 15, 0.95), (-6, -1, 8, 5, 1.05), (-6, 8, 8, 5, 1.02)):
            blob = away + [x, y] + np.stack([a * np.cos(angle), b * np.sin(angle)], 1) * setup.hand_size
            self.fill(canvas, at_depth(blob, 12), np.asarray(setup.skin) * tone)

    def shade(self, tip):
        setup = self.setup
        (u, v), = self.camera.project(at_depth([np.asarray(tip, float) + setup.shadow_at], 0))
        height, width = self.light.shape
        y, x = np.mgrid[:height, :width]
        spread = setup.shadow_size / self.camera.pixel()
        return 1 - setup.shadow * np.exp(-(((x - u) / spread) ** 2 + ((y - v) / spread) ** 2) / 2)
