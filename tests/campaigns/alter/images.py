"""Disturbances of 8-bit grey images: light, things in the way, blur, noise, compression, motion of the camera, faults of lens, sensor
and link. Each function takes the severity and returns a function of a moment and its image. The result for one moment is always
the same. Sizes are in pixels."""
import functools
import math

import cv2
import numpy as np

from alter.engine import Engine
from alter.moment import ALWAYS, has_begun

COVER = 140  # grey level of covers; differs from tool, background and object
FAR = 2000
DEVIATION = 24  # edge of the cells of hot air


# ---- together

def both(*paints):
    def paint(moment, image):
        for one in paints:
            image = one(moment, image)
        return image
    return paint


def on_side(side, paint):
    """Of a pair: only there."""
    return lambda moment, image: paint(moment, image) if moment.side == side else image


def since(when, paint):
    return lambda moment, image: paint(moment, image) if has_begun(when, moment) else image


# ---- helpers

def lround(x):
    return int(math.copysign(math.floor(abs(x) + 0.5), x))


def byte(values):
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)


def along(degrees):
    return np.array([math.cos(math.radians(degrees)), math.sin(math.radians(degrees))])


def grid(image):
    """Returns x and y of all pixels."""
    x, y = np.meshgrid(np.arange(image.shape[1]), np.arange(image.shape[0]))
    return x.astype(float), y.astype(float)


def middle_of(image):
    return np.array([0.5 * (image.shape[1] - 1), 0.5 * (image.shape[0] - 1)])


def engine_of(moment, what):
    return Engine((moment.index * 2 + moment.side) * 1000 + what)


def lit(image, light):
    return byte(image.astype(np.float32) * light.astype(np.float32))


def polygon(image, corners, grey):
    """Fills a polygon with anti-aliased edges. Its corners are rounded to 1/16 pixel."""
    points = np.array([[lround(16 * x), lround(16 * y)] for x, y in corners], np.int32)
    return cv2.fillConvexPoly(image, points, grey, cv2.LINE_AA, 4)


def disc(image, at, radius, grey):
    return cv2.circle(image, (lround(16 * at[0]), lround(16 * at[1])), lround(16 * radius), grey, -1, cv2.LINE_AA, 4)


def bar(image, a, b, width, grey):
    way = (b - a) / np.linalg.norm(b - a)
    half = 0.5 * width * np.array([-way[1], way[0]])
    return polygon(image, [a - half, a + half, b + half, b - half], grey)


def resampled(image, linear, by=(0, 0)):
    """Pixel p comes from linear (p - centre) + centre + by."""
    middle = middle_of(image)
    affine = np.column_stack([linear, middle - linear @ middle + by])
    return cv2.warpAffine(image, affine, image.shape[::-1], flags=cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP, borderMode=cv2.BORDER_REPLICATE)


def shifted(image, by):
    return resampled(image, np.eye(2), -np.asarray(by, float))


def remapped(image, x, y, how=cv2.INTER_LINEAR):
    return cv2.remap(image, x.astype(np.float32), y.astype(np.float32), how, borderMode=cv2.BORDER_REPLICATE)


def around(image, at, width, height):
    """Returns the part of the image around a place, as slices."""
    left, top = lround(at[0]) - width // 2, lround(at[1]) - height // 2
    return slice(max(0, top), max(0, top + height)), slice(max(0, left), max(0, left + width))


@functools.cache
def noise_bank(height, width):
    """Standard normal noise, larger than an image; each image uses another part of it."""
    bank = np.zeros((height + 256, width + 256), np.float32)
    cv2.setRNGSeed(7)
    return cv2.randn(bank, 0, 1)


# ---- light

def flicker(strength):
    # One light for both cameras. Incommensurable with the images, like mains light.
    return lambda moment, image: cv2.convertScaleAbs(image, alpha=1 + strength * math.sin(2.4 * moment.index))


def vignette(fall):
    """`fall`: fraction by which the corners are darker."""
    def paint(_, image):
        (x, y), (u, v) = grid(image), middle_of(image)
        return lit(image, 1 - fall * ((x - u) ** 2 + (y - v) ** 2) / (u * u + v * v))
    return paint


def gain(factor):
    return lambda _, image: cv2.convertScaleAbs(image, alpha=factor)


def gamma(exponent):
    levels = byte(255 * (np.arange(256) / 255) ** exponent)
    return lambda _, image: levels[image]


def shadow(depth):
    """A soft-edged band across tool and object; it wanders over them."""
    def paint(moment, image):
        place = moment.tip[0] - 60 + 120 * moment.share
        inside = (50 - np.abs(np.arange(image.shape[1]) - place)) / 6
        return lit(image, (1 - depth / (1 + np.exp(-inside)))[None])
    return paint


def glint_on_shaft(radius, distance):
    return lambda moment, image: disc(image, moment.tip + distance * moment.shaft, radius, 255)


def glint_on_tip(radius):
    return glint_on_shaft(radius, radius)


def glint_standing(radius, distance):
    return lambda moment, image: disc(image, moment.pressed + distance * moment.shaft, radius, 255)


def glint_beside(radius):
    return lambda moment, image: disc(image, moment.pressed + moment.width * moment.across, radius, 255)


def one_sided(strength):
    """Lighter at one side, darker at the other."""
    return lambda _, image: lit(image, (1 + strength * (2 * np.arange(image.shape[1]) / image.shape[1] - 1))[None])


# ---- things in the way

def wire(width, degrees, off, grey=30):
    """A straight wire across the whole image, at a distance of `off` along the shaft from the tip's position at full depth."""
    def paint(moment, image):
        through = moment.pressed + off * moment.shaft
        return bar(image, through - FAR * along(degrees), through + FAR * along(degrees), width, grey)
    return paint


def moving_wire(width):
    return lambda moment, image: wire(width, 20, 160 * (moment.share - 0.5))(moment, image)


def covered_side(share):
    """A plain patch that covers a fraction of the tool's width along the whole shaft and moves with it."""
    def paint(moment, image):
        width = share * moment.width + 4
        middle = moment.tip + (0.5 * moment.width + 4 - 0.5 * width) * moment.across
        return bar(image, middle, middle + FAR * moment.shaft, width, COVER)
    return paint


def covered_piece(begin, end):
    """A plain patch across the shaft, beyond the tip's place at full depth; it does not move."""
    return lambda moment, image: bar(image, moment.pressed + begin * moment.shaft, moment.pressed + end * moment.shaft, 3 * moment.width, COVER)


def hand(reach, when):
    """A large smooth blob that extends `reach` beyond the tip's position along the shaft; below 0 it ends before the tip."""
    return since(when, lambda moment, image: disc(image, moment.pressed + (90 - reach) * moment.shaft + 45 * moment.across, 90, 165))


def patches(places, radius, grey=200):
    def paint(moment, image):
        for at in places(moment):
            image = disc(image, at, radius, grey)
        return image
    return paint


def second_tool(aside):
    """Copies squares along the shaft, starting at the tip."""
    def paint(moment, image):
        edge, before = max(8, round(moment.width)), image.copy()
        for piece in range(300 // edge):
            at = moment.tip + (piece + 0.5) * edge * moment.shaft
            parts = [around(image, p, edge + 2, edge + 2) for p in (at, at + aside * moment.across)]
            if all(image[part].shape == (edge + 2, edge + 2) for part in parts):  # both are inside
                image[parts[1]] = before[parts[0]]
        return image
    return paint


def neighbour(beside):
    """A plain square beside the tip's position at full depth."""
    def paint(moment, image):
        image[around(image, moment.pressed + (beside + 40) * moment.across - 40 * moment.shaft, 80, 80)] = 110
        return image
    return paint


def rain(count):
    """Bright streaks at new places in each image."""
    def paint(moment, image):
        random, streaks = Engine(moment.index * 2 + moment.side + 29), np.zeros_like(image)
        for _ in range(count):
            x, y, grey = random.below(image.shape[1]), random.below(image.shape[0]), 40 + random.below(60)
            cv2.line(streaks, (x, y), (x + 6, y + 30), grey, 2, cv2.LINE_AA)
        return cv2.add(image, streaks)
    return paint


def insect(size):
    """Crawls over tool and object on a winding path that passes the tip's position at full depth in the middle of the run."""
    def paint(moment, image):
        way = moment.share - 0.5
        at = moment.pressed + [220 * way, 120 * way + 15 * math.sin(30 * way)]
        x, y = round(at[0]), round(at[1])
        cv2.ellipse(image, (x, y), (round(size), round(0.6 * size)), 30, 0, 360, 35, -1, cv2.LINE_AA)
        for leg in range(6):
            angle = leg * math.pi / 3 + 0.3 * math.sin(2.0 * moment.index)
            cv2.line(image, (x, y), (x + round(1.8 * size * math.cos(angle)), y + round(1.8 * size * math.sin(angle))), 35, 1, cv2.LINE_AA)
        return image
    return paint


# ---- blur, noise, compression

def defocus(sigma):
    return lambda _, image: cv2.GaussianBlur(image, (0, 0), sigma, sigmaY=sigma, borderType=cv2.BORDER_REPLICATE)


def lose_focus(sigma):
    return lambda moment, image: defocus(sigma * moment.share)(moment, image) if moment.index > 0 else image


def motion_blur(length, degrees):
    """The kernel is a line that is a pixel wide; its values are pixel coverages."""
    half = math.ceil(0.5 * length) + 1
    kernel = np.zeros((2 * half + 1, 2 * half + 1), np.float32)
    for i in range(400):
        px, py = ((i + 0.5) / 400 - 0.5) * length * along(degrees)
        x, y = math.floor(px), math.floor(py)
        fx, fy = px - x, py - y
        for dy, wy in ((0, 1 - fy), (1, fy)):
            for dx, wx in ((0, 1 - fx), (1, fx)):
                kernel[half + y + dy, half + x + dx] += wx * wy
    kernel /= kernel.sum()
    return lambda _, image: cv2.filter2D(image, -1, kernel, borderType=cv2.BORDER_REPLICATE)


def noise(sigma):
    """`sigma`: grey levels."""
    def paint(moment, image):
        bank, random, (height, width) = noise_bank(*image.shape), engine_of(moment, 1), image.shape
        x, y = random.below(bank.shape[1] - width), random.below(bank.shape[0] - height)
        return byte(image + np.float32(sigma) * bank[y:y + height, x:x + width])
    return paint


def jpeg(quality):
    return lambda _, image: cv2.imdecode(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])[1], cv2.IMREAD_GRAYSCALE)


# ---- the camera moves

def bump(by, when):
    return since(when, lambda _, image: shifted(image, by))


def shake(sigma, same=False):
    """Drawn for each image. `same`: for both cameras."""
    def paint(moment, image):
        if moment.index == 0:
            return image
        random = Engine((moment.index * 2 + (0 if same else moment.side)) * 1000 + 2)
        return shifted(image, [random.normal(sigma), random.normal(sigma)])
    return paint


def drift(by):
    """Evenly, over the whole run."""
    return lambda moment, image: shifted(image, moment.share * np.asarray(by))


def zoom(factor, when):
    return since(when, lambda _, image: resampled(image, np.eye(2) / factor))


def breathing(factor):
    return lambda moment, image: zoom(1 + (factor - 1) * moment.share, ALWAYS)(moment, image)


def turn(degrees, when):
    c, s = along(degrees)
    return since(when, lambda _, image: resampled(image, np.array([[c, -s], [s, c]])))


def turn_slowly(degrees):
    return lambda moment, image: turn(degrees * moment.share, ALWAYS)(moment, image)


def barrel(px):
    """Distortion that is not in the scene: so far inwards in the corners; below 0 pincushion."""
    def paint(_, image):
        (x, y), (u, v) = grid(image), middle_of(image)
        k = px / math.hypot(u, v) ** 3
        factor = 1 + k * ((x - u) ** 2 + (y - v) ** 2)
        return remapped(image, u + (x - u) * factor, v + (y - v) * factor, cv2.INTER_CUBIC)
    return paint


# ---- on the lens

def smudge(blur, veil):
    """A soft patch over the tip's place at full depth: blurred, its contrast lower by `veil`."""
    def paint(moment, image):
        smeared = cv2.GaussianBlur(image, (0, 0), blur).astype(np.float32) * np.float32(1 - veil) + np.float32(veil * 150)
        mask = np.zeros(image.shape, np.float32)
        cv2.circle(mask, (round(moment.pressed[0]), round(moment.pressed[1])), 35, 1, -1)
        sharp = image.astype(np.float32)
        return byte(sharp + (smeared - sharp) * cv2.GaussianBlur(mask, (0, 0), 6))
    return paint


def dust(count):
    """Dark specks of 2 to 5 px all over the image, standing still."""
    def paint(_, image):
        random = Engine(11)
        for _ in range(count):
            at = random.below(image.shape[1]), random.below(image.shape[0])
            # Of the arguments of a call the compiler evaluates the left one first.
            radius, grey = 2 + random.below(4), 40 + random.below(60)
            cv2.circle(image, at, radius, grey, -1, cv2.LINE_AA)
        return image
    return paint


def haze(veil):
    """Contrast lower, towards white, growing over the run."""
    return lambda moment, image: cv2.convertScaleAbs(image, alpha=1 - veil * moment.share, beta=235 * veil * moment.share)


def fog(veil):
    """Haze in the half of the image beside the tip's position at full depth."""
    def paint(moment, image):
        here = veil * moment.share / (1 + np.exp(-(np.arange(image.shape[1]) - moment.pressed[0]) / 25))
        return byte(image.astype(np.float32) * (1 - here).astype(np.float32) + (200 * here).astype(np.float32))
    return paint


def droplet(pull):
    """A drop of 40 px radius beside the tip's position at full depth. It displaces the image within it outwards."""
    def paint(moment, image):
        (x, y), middle = grid(image), moment.pressed + [15, 5]
        ax, ay = (x - middle[0]) / 40, (y - middle[1]) / 40
        inside = 1 - (ax * ax + ay * ay)
        part = np.where(inside > 0, 16 / 9 * inside * inside * 2, 0)
        return remapped(image, x - pull * part * ax, y - pull * part * ay)
    return paint


def ghost(share):
    """A reflection in glass: a second image, shifted."""
    def paint(_, image):
        aside = cv2.warpAffine(image, np.array([[1.0, 0, 14], [0, 1, 5]]), image.shape[::-1], flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return cv2.addWeighted(image, 1 - share, aside, share, 0)
    return paint


def heat_haze(sigma):
    """Parts are shifted differently in each image."""
    def paint(moment, image):
        cv2.setRNGSeed(moment.index * 2 + moment.side + 23)
        coarse = np.zeros((image.shape[0] // DEVIATION + 2, image.shape[1] // DEVIATION + 2, 2), np.float32)
        cv2.randn(coarse, (0, 0), (sigma, sigma))
        by, (x, y) = cv2.resize(coarse, image.shape[::-1], interpolation=cv2.INTER_CUBIC), grid(image)
        return remapped(image, x + by[..., 0], y + by[..., 1])
    return paint


# ---- in the sensor

def move_rows(image, shift):
    """Moves each row along x by shift(row)."""
    x, y = grid(image)
    return remapped(image, x - shift(y), y)


def wobble(px):
    """Shifts each row by a moving wave with a length of 120 rows."""
    return lambda moment, image: move_rows(image, lambda row: px * np.sin(row * 2 * math.pi / 120 + 1.9 * moment.index))


def comb(px):
    """Shifts every other row."""
    return lambda _, image: move_rows(image, lambda row: px * (row % 2))


def dead_rows(count, level):
    def paint(moment, image):
        image[around(image, moment.pressed, 4 * image.shape[1], count)] = level
        return image
    return paint


def dead_columns(count, level):
    def paint(moment, image):
        image[around(image, moment.pressed, count, 4 * image.shape[0])] = level
        return image
    return paint


def hot_pixels(share):
    def paint(_, image):
        random, flat = Engine(13), image.ravel()
        flat[[random() % flat.size for _ in range(int(share * flat.size))]] = 255
        return flat.reshape(image.shape)
    return paint


def waves_of_rows(strength, length, phase):
    def paint(moment, image):
        row = np.arange(image.shape[0])
        return lit(image, (1 + strength * np.sin(row * 2 * math.pi / (length or image.shape[0]) + phase * moment.index))[:, None])
    return paint


def banding(strength):
    """Bands of 40 rows lighter and darker, wandering."""
    return waves_of_rows(strength, 40, 2.1)


def rolling_gain(strength):
    """One bright and one dark half, wandering down."""
    return waves_of_rows(strength, None, -1.3)


def quantised(levels):
    step = 256 / levels
    table = byte((np.floor(np.arange(256) / step) + 0.5) * step)
    return lambda _, image: table[image]


def stuck_rows(count):
    """The rows below the tip's position at full depth repeat the row there."""
    def paint(moment, image):
        begin = min(max(round(moment.pressed[1]), 0), image.shape[0] - 1)
        image[begin + 1:begin + 1 + count] = image[begin]
        return image
    return paint


def dead_clusters(count):
    """Black, of 3 to 7 px, all over the image."""
    def paint(_, image):
        random = Engine(19)
        for _ in range(count):
            x, y, width, height = random.below(image.shape[1]), random.below(image.shape[0]), 3 + random.below(5), 3 + random.below(5)
            image[y:y + height, x:x + width] = 0
        return image
    return paint


def moire(levels):
    """Waves of 2.7 px and of 31 px multiplied, standing."""
    def paint(_, image):
        x, y = grid(image)
        waves = levels * np.sin((x + 0.3 * y) * 2 * math.pi / 2.7) * np.sin((y - 0.4 * x) * 2 * math.pi / 31)
        return byte(image + waves.astype(np.float32))
    return paint


def inverted():
    return lambda _, image: 255 - image


# ---- on the line

def part_of(image, part, share):
    rows = int(share * image.shape[0])
    return slice(0, rows) if part == "upper" else slice(image.shape[0] - rows, image.shape[0])


def partly_grey(part, share):
    def paint(_, image):
        image[part_of(image, part, share)] = 128
        return image
    return paint


def partly_old(part, share, side=None):
    """Returns a function that makes masks of pixels which keep the content of the first image."""
    def mask(moment, image):
        old = np.zeros(image.shape, bool)
        if side is None or moment.side == side:
            old[part_of(image, part, share)] = True
        return old
    return mask


def blocks_lost(share):
    """The same for blocks of 16 px."""
    def mask(moment, image):
        old, random = np.zeros(image.shape, bool), Engine(moment.index * 2 + moment.side + 17)
        for y in range(0, image.shape[0], 16):
            for x in range(0, image.shape[1], 16):
                if random.uniform() < share:
                    old[y:y + 16, x:x + 16] = True
        return old
    return mask


def mirrored(flip_code):
    return lambda _, image: cv2.flip(image, flip_code)


def resized(factor):
    return lambda _, image: cv2.resize(image, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)


# ---- a membrane before a pair of cameras

def projected(camera, p):
    """Returns where a camera shows points of space, (..., 3) -> (..., 2)."""
    (fx, fy, cx, cy), X = camera["lens"], np.reshape(camera["X_CS"], (3, 4))
    q = p @ X[:, :3].T + X[:, 3]
    return np.stack([fx * q[..., 0] / q[..., 2] + cx, fy * q[..., 1] / q[..., 2] + cy], -1)


def dome(height):
    """The membrane bulges as a paraboloid by `height` [m] towards -z at its centre. Each pixel shows the point where its ray meets the
    plane, displaced by the bulge there."""
    maps = {}

    def paint(moment, image):
        if moment.side not in maps:
            camera, (x, y) = moment.space["cameras"][moment.side], grid(image)
            (fx, fy, cx, cy), X = camera["lens"], np.reshape(camera["X_CS"], (3, 4))
            at, d = -X[:, :3].T @ X[:, 3], np.stack([(x - cx) / fx, (y - cy) / fy, np.ones(x.shape)], -1) @ X[:, :3]
            p = at - (at[2] / d[..., 2])[..., None] * d
            bulge = height * np.maximum(0, 1 - (p[..., :2] ** 2).sum(-1) / moment.space["radius"] ** 2)
            by = projected(camera, p - bulge[..., None] * [0, 0, 1]) - projected(camera, p)
            maps[moment.side] = x - by[..., 0], y - by[..., 1]
        return remapped(image, *maps[moment.side], cv2.INTER_CUBIC)
    return paint


def covered_dots(count):
    """So many of the dots, or of the places where they would be, behind plain discs."""
    def places(moment):
        dots = moment.space["cameras"][moment.side]["dots"]
        return [dots[6 * i % len(dots)] for i in range(count)]
    return patches(places, 14)


# ---- depth images: 16 bits, 0 is no measurement

def holes(share, standing):
    """Removes measurements in discs of 20 px that cover a fraction of the image, at new positions in each image unless they stand."""
    def paint(moment, image):
        random = Engine(1 if standing else moment.index + 1)
        for _ in range(int(share * image.size / (math.pi * 400))):
            cv2.circle(image, (int(random.uniform() * image.shape[1]), int(random.uniform() * image.shape[0])), 20, 0, -1)
        return image
    return paint


def rescaled(factor, offset, when):
    """Multiplies each depth by `factor` and adds `offset` [counts]."""
    return since(when, lambda _, image: np.clip(np.rint(image * np.float32(factor) + np.float32(offset)), 0, 65535).astype(np.uint16))


def noisy_depth(counts):
    def paint(moment, image):
        cv2.setRNGSeed(moment.index + 1)
        random = cv2.randn(np.zeros(image.shape, np.float32), 0, counts)
        return np.clip(np.rint(image + random), 0, 65535).astype(np.uint16)
    return paint
