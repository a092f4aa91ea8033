"""The position of a sample in a run, and the places of the parts in its image."""
import dataclasses
from typing import NamedTuple

import numpy as np


class Script(NamedTuple):
    """A press in numbers of samples: rest, approach, hold, retreat, rest."""
    way: int  # first sample of the approach; samples before it give the rest state
    touch: int  # the first in contact
    hold: int  # the first at the full depth
    back: int  # first sample of the retreat
    count: int


@dataclasses.dataclass
class Moment:
    script: Script
    index: int
    side: int = 0  # of a pair: 0 left, 1 right
    tip: np.ndarray | None = None  # the tool's tip; for pairs: the pressed point [px]
    pressed: np.ndarray | None = None  # position of the tip at full depth [px]
    shaft: np.ndarray | None = None  # unit vector, from the tip along the tool's shaft
    width: float = 0.0  # of the tool [px]
    space: dict | None = None  # of a pair: lenses, poses and dots of both cameras

    @property
    def share(self):
        """The completed fraction of the run, 0 to 1."""
        return self.index / (self.script.count - 1) if self.script.count > 1 else 0.0

    @property
    def across(self):
        return np.array([-self.shaft[1], self.shaft[0]])


# Starts of an alteration.
ALWAYS, AT_REST, PRESSED = "always", "at rest", "pressed"


def has_begun(when, moment):
    script = moment.script
    return when == ALWAYS or moment.index >= (script.way if when == AT_REST else (script.hold + script.back) // 2)
