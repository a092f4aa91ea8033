"""Ten kinds of plausible set-ups: body, tool, camera, surroundings, and what the person knows and clicks."""
import math

import numpy as np

from truth.bodies import Block, Sheet, Tool, solid_share
from truth.render import Camera, at_depth, finer

KINDS = ("block", "round", "disc", "trapezoid", "stick", "cube", "kidney", "arc", "clutter", "foam")
RATE = 30  # images per second
CLICK_PX = 1.5  # standard deviation of a click


class Setup:
    """One set-up. `remedies` are changes that the page has requested: a strip of `tape`, or the camera at the `height`
    of the pressed edge."""

    def __init__(self, number, remedies=(), size=(640, 480)):
        self.kind, self.remedies = KINDS[number % len(KINDS)], tuple(remedies)
        self.rng = rng = np.random.default_rng(1000 + number)
        # Distance from the body to the tool at the start.
        self.above = 4.0 if "near" in self.remedies else max(4.0, np.random.default_rng(5000 + number).uniform(3, 6))
        def draw(low, high, step=0.0):
            value = rng.uniform(low, high)
            return round(round(value / step) * step, 6) if step else value
        self.draw = draw
        width, height = draw(50, 100, 1), draw(45, 80, 1)
        self.thickness, self.poisson, self.modulus = draw(7, 12, 0.5), 0.49, draw(30, 200, 1)
        tool, shape, tilt = draw(5, 8, 0.1), "flat", rng.normal(0, 0.008)
        self.by, self.extent, self.plane = "whole", None, "stress"
        self.background, self.wall = "wall", draw(70, 150)
        self.colour = np.array([draw(60, 200), draw(60, 200), draw(60, 200)])
        self.tool_colour = np.array([45.0, 45, 50])
        self.noise, self.blur, drift, tremor = draw(1.5, 3), draw(0.5, 0.8), 0.03, 0.1
        self.light, self.shadow, self.hand_size = (rng.normal(0, 0.08), rng.normal(0, 0.08)), 0.1, draw(0.9, 1.2)
        self.focal, raised = 610.0 * size[0] / 640, False
        getattr(self, "_" + self.kind, lambda *_: None)(width, height)
        width, height = getattr(self, "size", (width, height))
        if self.kind == "round":
            tool, shape = draw(8, 12, 0.5), "round"
        if self.kind in ("stick", "cube"):
            tool, tilt, tremor, raised = 6.0, 0.0, 0.03, self.kind == "stick"
            self.by, self.extent = "part", 6.0
        if self.kind == "foam":
            self.poisson, self.modulus, drift, tremor, self.shadow = 0.3, draw(15, 60, 1), 0.05, 0.2, 0.2
            tilt = rng.choice([-1, 1]) * draw(0.01, 0.03)
        self.width, self.height = width, height
        # The object differs from its background.
        if "sheet" in self.remedies:
            self.background, self.wall = "wall", 175.0 if self.tool_colour.mean() < 100 else 60.0
        if abs(self.colour.mean() - self.wall) < 45 and self.kind != "disc":
            self.colour = self.colour + math.copysign(60, self.colour.mean() - self.wall + 1e-9)
            self.colour = np.clip(self.colour, 30, 240)
        if abs(self.tool_colour.mean() - self.wall) < 35:
            self.tool_colour = self.tool_colour + 110
        self.tool_width, self.tool_shape = tool, shape
        self.tool = Tool(tool, shape, tilt)
        self.tool_length, self.grip = 60.0, 62.0
        self.bands = [(3.0 + 4 * i, 5.0 + 4 * i, (220, 220, 215) if i % 2 == 0 else (25, 25, 25)) for i in range(3)] \
            if self.kind != "disc" or "tape" in self.remedies else []
        self.skin = np.array([190.0, 145, 120]) * draw(0.5, 1.1)
        self.shadow_at, self.shadow_size = (draw(-40, 40), draw(20, 50)), draw(25, 45)
        self.drift, self.tremor = drift, tremor
        self.outline, self.place, self.top = self._outline()
        low = self.outline[:, 1].min()
        room = self.top - low + 14 + (40 if self.kind == "cube" else 0)  # extent below the centre of the image
        pixel = max(max(width, height) / (draw(200, 260) * size[0] / 640), room / (0.475 * size[1]))
        # A person who follows the guide mounts the lens straight, at the height of the gap between object and tool; for
        # a block higher.
        eye = 0.5 * self.top if raised and "height" not in self.remedies else self.top + self.above / 2 + rng.normal(0, 3)
        eye = self.top + 40 if self.kind == "cube" else eye
        aside = self.place[0] if "middle" in self.remedies else width / 2 + self.left + 0.06 * width
        at = (aside + 0.03 * width * rng.normal(), eye, self.focal * pixel)
        self.camera = Camera(at, self.focal, size, rng.normal(0, 0.006, 3), draw(-0.02, 0.02))
        self.depth = draw(0.035, 0.05) * height
        if self.by == "part" and self.kind == "cube":
            self.depth = 2.5

    left = 0.0

    def _disc(self, width, height):
        self.size = (70.0, 70.0)
        self.colour, self.tool_colour, self.wall = np.array([228.0, 226, 220]), np.array([205.0, 180, 60]), 108.0

    def _arc(self, width, height):
        side = self.draw(50, 80, 1)
        self.size = (side, side)

    def _trapezoid(self, width, height):
        self.background = "photo"
        self.slope = self.draw(0.08, 0.18) * width

    def _cube(self, width, height):
        self.size, self.thickness, self.plane = (60.0, 60.0), 60.0, "block"
        self.poisson, self.modulus = 0.45, self.draw(30, 100, 1)

    def _stick(self, width, height):
        self.thickness, self.poisson = 9.0, 0.45

    def _kidney(self, width, height):
        self.poisson = 0.45

    def _clutter(self, width, height):
        self.background = "clutter"

    @property
    def is_disc(self):
        return self.kind in ("disc", "arc")

    def _outline(self):
        width, height = self.width, self.height
        if self.is_disc:
            self.left = -width / 2
            angles = np.linspace(0, 2 * math.pi, 240, endpoint=False) - math.pi / 2
            return width / 2 * np.stack([np.cos(angles), np.sin(angles)], 1), np.array([0, width / 2]), width / 2
        if self.kind == "trapezoid":
            points = np.array([[0, 0], [width, 0], [width - self.slope, height], [self.slope, height]])
            return points, np.array([width / 2, height]), height
        if self.kind == "kidney":
            angles = np.linspace(0, 2 * math.pi, 200, endpoint=False)
            radius = 1 + 0.1 * np.cos(2 * angles) - 0.06 * np.sin(3 * angles) + 0.04 * np.cos(3 * angles)
            points = np.stack([width / 2 * radius * np.cos(angles), height / 2 * radius * np.sin(angles)], 1)
            self.left = -width / 2
            return points, points[points[:, 1].argmax()], points[:, 1].max()
        points = np.array([[0, 0], [width, 0], [width, height], [0, height]])
        return points, np.array([width / 2 + 0.08 * width * self.rng.normal(), height]), height

    def held(self, X):
        """Returns which nodes are fixed."""
        if self.is_disc or self.kind == "kidney":
            angle = np.arctan2(X[:, 1], X[:, 0])
            outer = np.hypot(*X.T) > 0.997 * np.interp(angle, *self._polar(np.hypot(*self.outline.T)))
            angle = np.degrees(angle)
            low, high = self.arc
            return outer & (angle > low - 1e-6) & (angle < high + 1e-6)
        return X[:, 1] < 1e-6

    @property
    def arc(self):
        """Returns the ends of the fixed part [degrees]."""
        return {"disc": (-150, -30), "arc": (-112.5, -67.5), "kidney": (-140, -40)}[self.kind]

    def tool_span(self):
        """Returns the z range of the tool from front to back."""
        if self.by == "whole":
            return 1.0, -self.thickness - 1.0
        middle = -self.thickness / 2
        return middle + self.extent / 2, middle - self.extent / 2

    def support(self):
        """Returns polygons with their colours for the table or stand below."""
        low, left, right = self.outline[:, 1].min(), self.left, self.left + self.width
        if self.is_disc or self.kind == "kidney":  # a cradle that holds the lower part
            angles = np.radians(np.linspace(*self.arc, 30))
            radius = np.hypot(*self.outline.T)
            at = np.stack([np.interp(angles, *self._polar(radius)) * np.cos(angles), np.interp(angles, *self._polar(radius)) *
                           np.sin(angles)], 1)
            shape = np.concatenate([at, [[at[-1, 0], low - 10], [at[0, 0], low - 10]]])
        else:
            shape = np.array([[left - 6, low], [right + 6, low], [right + 6, low - 10], [left - 6, low - 10]])
        tone = 38.0 if self.colour.mean() > 110 else 200.0
        return [(at_depth(shape, -self.thickness), (tone, tone, tone)), (at_depth(shape, 0.0), (tone, tone * 0.95, tone * 0.9))]

    def _polar(self, radius):
        angles = np.arctan2(self.outline[:, 1], self.outline[:, 0])
        order = angles.argsort()
        return np.concatenate([angles[order] - 2 * math.pi, angles[order], angles[order] + 2 * math.pi]), np.tile(radius[order], 3)

    RULER = 80.0

    def ruler(self):
        """Returns polygons with their colours for an upright ruler beside the body."""
        x, y = self.left + self.width + 10, self.outline[:, 1].min() - 6
        self.ruler_marks = [[x + 3, y], [x + 3, y + self.RULER]]
        parts = [(at_depth([[x, y - 4], [x + 9, y - 4], [x + 9, y + self.RULER + 4], [x, y + self.RULER + 4]], 0), (235, 235, 230))]
        for i in range(int(self.RULER / 2) + 1):
            a, long = y + 2 * i, 6 if i % 5 == 0 else 3
            parts.append((at_depth([[x, a - 0.2], [x + long, a - 0.2], [x + long, a + 0.2], [x, a + 0.2]], 0), (20, 20, 20)))
        return parts

    def tips(self):
        """Returns the tip position in each image: at rest, down, up, at rest, with tremor."""
        rng, high = self.rng, self.above
        way = np.concatenate([np.zeros(5), (1 - np.cos(np.linspace(0, math.pi, 24))) / 2, np.ones(4),
                              (1 + np.cos(np.linspace(0, math.pi, 14))) / 2, np.zeros(2)])
        t = np.arange(len(way)) / RATE + rng.normal(0, 0.003, len(way))
        wander = sum(np.outer(np.sin(2 * math.pi * f * t + rng.uniform(0, 6)), rng.normal(0, 1, 2)) for f in (0.6, 1.7, 6.5, 9.0))
        wander = self.tremor * (wander - wander[0]) / 2
        along = -high + way * (high + self.depth)
        return self.place + along[:, None] * self.tool.direction + wander

    def gains(self, count):
        return 1 + self.drift * np.sin(np.linspace(0, 2.4, count)) * (1 if self.rng.random() < 0.5 else -1)

    def press(self):
        """Returns (force [N], outline) for each image."""
        tips = self.tips()
        if self.by == "part":
            body = Block((self.width, self.height, self.thickness), self.place[0], self.tool_width, self.extent, self.poisson)
            unit = 1e-3 * self.modulus
        else:
            body = Sheet(self.outline, self.held, self.place, self.tool_width, self.poisson)
            box = (self.width, self.height, self.thickness)
            unit = 1e-3 * self.modulus * self.thickness * solid_share(box, self.place[0] - self.left, self.tool_width, self.poisson)
        return tips, [(unit * force, outline) for force, outline in body.press(self.tool, tips)]

    def clicks(self, seed):
        """Returns the input of the person: clicked positions in the image with random errors, and the true sizes."""
        rng = np.random.default_rng(seed)
        def click(points, z=0.0):
            return (self.camera.project(at_depth(points, z)) + rng.normal(0, CLICK_PX, (len(np.atleast_2d(points)), 2))).tolist()
        self.ruler()
        edge = self.outline
        kind = {"disc": "disc", "arc": "disc", "trapezoid": "polygon", "kidney": "outline"}.get(self.kind, "rectangle")
        if kind == "disc":
            angles = np.array([0.3, 1.2, 2.6, 3.4, 6.0])
            points = self.width / 2 * np.stack([np.cos(angles), np.sin(angles)], 1)
        else:
            points = edge[::10] if kind == "outline" else edge
        arcs = []
        if kind in ("disc", "outline"):
            angles, (polar, radius) = np.radians(self.arc), self._polar(np.hypot(*edge.T))
            at = np.interp(angles, polar, radius)
            arcs = click(np.stack([at * np.cos(angles), at * np.sin(angles)], 1))
        sides = np.hypot(*(np.roll(edge, -1, 0) - edge).T) if kind == "polygon" else []
        tip = self.place - self.above * self.tool.direction
        front = self.tool_span()[0]
        (u, v), = self.camera.project(at_depth([tip], front))
        half = self.tool.half / self.camera.pixel()
        return {
            "kind": kind, "scale": click(self.ruler_marks), "length": self.RULER, "points": click(points),
            "width": self.width, "height": self.height, "sides": "; ".join(f"{side:.1f}" for side in sides), "arcs": arcs,
            "thickness": self.thickness, "modulus": self.modulus, "poisson": self.poisson, "tool": self.tool_width, "shape": self.tool_shape,
            "by": self.by, "extent": self.extent, "box": [[u - half - 14, v - 55], [u + half + 14, v + 10]], "tip": [u, v],
            "outline": self.camera.project(at_depth(finer(edge), 0)).tolist(), "distance": float(round(self.camera.at[2])), "plane": self.plane, "higher": self.camera.at[1] - self.top,
        }
