"""Presses that `campaign_cell` simulates, and alterations of their samples that it plays to a slave."""
import copy
import dataclasses
import functools
import json
import math
import subprocess
from typing import Callable

import numpy as np

import runners
from alter.images import shifted
from alter.moment import Moment, Script, has_begun
from campaign import Estimate, Skipped

PROGRAM = runners.BIN / "campaign_cell"


@dataclasses.dataclass
class Alteration:
    """What lies between the world and a sense. None changes nothing."""
    paint: Callable | None = None  # moment, image -> image; last of all
    shows: Callable | None = None  # moment -> index of the sample that is shown instead; timestamps are unchanged
    stale: Callable | None = None  # moment, image -> mask of what keeps the content of the first image
    object_moves: Callable | None = None  # moment -> rigid displacement of the object in the image [px]; for one camera only
    swapped: str | None = None  # from when on left and right are exchanged
    touch: Callable | None = None  # moment, fingers; changes their readings
    loses: Callable | None = None  # moment -> whether this sample is lost on the link
    edits: Callable | None = None  # stage -> edits of the scene that the sense gets
    arm_error: float = 0.0  # error of the arm's reported tip [px], or [m] without images


def in_turn(first, second, *, joined):
    return joined if first and second else first or second


def together(a, b):
    """Returns `a`, then `b`. They must not both choose which sample is shown."""
    return Alteration(
        paint=in_turn(a.paint, b.paint, joined=lambda moment, image: b.paint(moment, a.paint(moment, image))),
        shows=a.shows or b.shows,
        stale=in_turn(a.stale, b.stale, joined=lambda moment, image: a.stale(moment, image) | b.stale(moment, image)),
        object_moves=in_turn(a.object_moves, b.object_moves, joined=lambda moment: np.add(a.object_moves(moment), b.object_moves(moment))),
        swapped=a.swapped or b.swapped,
        touch=in_turn(a.touch, b.touch, joined=lambda moment, fingers: (a.touch(moment, fingers), b.touch(moment, fingers))),
        loses=in_turn(a.loses, b.loses, joined=lambda moment: a.loses(moment) or b.loses(moment)),
        edits=in_turn(a.edits, b.edits, joined=lambda stage: a.edits(stage) + b.edits(stage)),
        arm_error=a.arm_error + b.arm_error)


@functools.cache
def program():
    if not PROGRAM.exists():
        raise Skipped(f"no {PROGRAM}: expected deploy/build.sh release -DPALPATE_TESTS=ON -- campaigns")
    return subprocess.Popen([PROGRAM], stdin=subprocess.PIPE, stdout=subprocess.PIPE)


def ask(request, images=()):
    """Returns the answer of the program. Its images follow in its output."""
    process = program()
    process.stdin.write(json.dumps(request).encode() + b"\n" + b"".join(image.tobytes() for image in images))
    process.stdin.flush()
    line = process.stdout.readline()
    if not line:
        raise RuntimeError(f"campaign_cell ended at {str(request)[:300]}")
    return json.loads(line)


class Stage:
    """A simulated press. `counts`: samples of rest, approach, hold, retreat and rest. `edits`: of the true scene."""
    current = None  # the press that the program has

    def __init__(self, kind, scene, counts, overrides=(), edits=(), coarse=True):
        self.kind, self.request = kind, {"do": "run", "kind": kind, "scene": scene, "overrides": list(overrides), "edits": list(edits),
                                         "counts": list(counts), "coarse": coarse, "moves": []}
        self.shots, self.images = self._simulate([])
        rest, approach, hold, back, after = counts
        touch = next((i for i, shot in enumerate(self.shots) if shot["touches"]), rest + approach)
        self.script = Script(rest, min(touch, rest + approach), rest + approach, rest + approach + hold, rest + approach + hold + back + after)

    def _simulate(self, moves):
        answer = ask({**self.request, "moves": moves})
        Stage.current = (self, moves)
        if not moves:
            self.peak, self.pixel, self.space = answer["peak"], answer["pixel"], answer["space"]
            self.finger_radius, self.pose_tolerance = (answer.get(key, 0) for key in ("finger_radius", "pose_tolerance"))
        if "shape" not in answer:
            return answer["shots"], []
        (rows, columns), sides, size = answer["shape"], answer["sides"], answer["bytes"]
        count = len(answer["shots"]) * sides
        flat = np.frombuffer(program().stdout.read(count * rows * columns * size), np.uint8 if size == 1 else np.uint16)
        return answer["shots"], flat.reshape(len(answer["shots"]), sides, rows, columns)

    def moment(self, index, side=0):
        tip, pressed, shaft, width = self.shots[index]["views"][side]
        return Moment(self.script, index, side, np.array(tip), np.array(pressed), np.array(shaft), width, self.space)

    def _image(self, images, alteration, index, side):
        shown = index if alteration.shows is None else alteration.shows(self.moment(index, side))
        moment, image = self.moment(shown, side), images[shown, side].copy()
        if alteration.stale:
            image = np.where(alteration.stale(moment, image), images[0, side], image)
        return alteration.paint(moment, image) if alteration.paint else image

    def replay(self, alteration):
        """Returns the estimates after rest as (index of the sample, Estimate), and the refusal or None."""
        images, moves = self.images, []
        if alteration.object_moves:
            moves = [list(map(float, alteration.object_moves(self.moment(i)))) for i in range(self.script.count)]
        if Stage.current != (self, moves):
            _, images = self._simulate(moves)
            if moves:
                images = np.array([[shifted(image, move) for image in sample] for sample, move in zip(images, moves)])
        samples, sent = [], []
        for index in range(self.script.count):
            moment = self.moment(index)
            if alteration.loses and alteration.loses(moment):
                continue
            sample = {"index": index}
            if len(images):
                pair = [np.ascontiguousarray(self._image(images, alteration, index, side)) for side in range(images.shape[1])]
                if alteration.swapped and has_begun(alteration.swapped, moment):
                    pair.reverse()
                sample["shapes"] = [image.shape for image in pair]
                sent += pair
            else:
                shown = index if alteration.shows is None else alteration.shows(moment)
                fingers = copy.deepcopy(self.shots[shown]["fingers"])
                if alteration.touch:
                    alteration.touch(moment, fingers)
                sample["fingers"] = fingers
            samples.append(sample)
        answer = ask({"do": "replay", "edits": alteration.edits(self) if alteration.edits else [], "samples": samples,
                      "arm_error": alteration.arm_error * self.pixel, "rest": self.script.way}, sent)
        return [(index, Estimate(force and tuple(force), tuple(truth), math.nan if sigma is None else sigma, validity, check))
                for index, force, sigma, validity, check, truth in answer["rows"]], answer["refused"]
