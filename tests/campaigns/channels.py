"""Faults of single channels and of the driver of a tactile sensor: recordings of a simulated pad, altered, through `process`.

The pad and the training are those of deploy/guides/own-tactile-sensor.md. Each case is a recording of three presses that the
training did not contain, with one fault that begins at a random time of the first or second press:

  dead       the channel reads 0
  stuck      it keeps its last value
  jump       it reads 2 to 20 kPa more or less
  saturated  it reads at most a tenth to a half of its largest change above its reading at rest
  swapped    it changes places with another channel
  drift      it rises or falls by 0.5 to 5 kPa/s
  frozen     the driver repeats its last sample
  touched    the recording begins in a press

The channel is one of those that this press changes by more than a fifth of the largest change. Ten unaltered recordings come
first. A state is silent if it is `valid` and off by more than three sigma and more than 5 % of the largest force. The first
0.1 s after the begin of a fault do not count: the checks need ten samples.
"""
import numpy as np

import campaign
import runners
from campaign import Case, Estimate

from taxel_sensor import RATE, REST, Pad, record, samples

COUNT = 100
KINDS = ["dead", "stuck", "jump", "saturated", "swapped", "drift", "frozen", "touched"]
SETTLED = 0.1  # [s]
TOUCHES = 0.05  # of the largest force
SIGMAS, MAX_ERROR = 3, 0.05
UNALTERED = 10  # recordings
MAX_FLAGGED = 0.1  # of their contact states: 2 % with 16 taxels, 7 % with 60
SCENE = """name: taxel-pad
object:
  geometry: {{box: {{size: [60 mm, 60 mm, 60 mm], cells: [6, 6, 6]}}}}
  material: {{young_modulus: 3.8 kPa, poisson_ratio: 0.15}}
  fixed: {{plane: {{axis: z, at: 0 mm}}}}
sense:
  tactile: {{source: altered.csv, finger: pad, channels: {taxels}, unit: kPa, network: {network}, rest: first 50}}
model: {{kind: fem}}
"""


def arguments(parser):
    parser.add_argument("--taxels", type=int, choices=(16, 60), default=16)


def trained(options):
    """Returns the folder of a network that is trained on 60 presses."""
    network = options.folder / "network"
    if not network.exists():
        record(options.folder / "presses", options.taxels, 60, 1)
        runners.run_python("palpate.train", options.folder / "presses", "--unit", "kPa", "--out", network)
    return network


def press(taxels, seed):
    """Readings [kPa], n x taxels, and forces of the pad on the object [N], n x 3."""
    readings, forces = zip(*samples(Pad(taxels, seed), 3))
    return np.array(readings), np.array(forces)


def begin_of_fault(forces, random):
    """A sample at which a press has reached half its largest force, of the first or second press."""
    size = np.linalg.norm(forces, axis=1)
    starts = [k for k in range(1, len(size)) if size[k] > 0 and size[k - 1] == 0]
    first = starts[random.integers(2)]
    length = next(k for k in range(first, len(size)) if size[k] == 0) - first
    return first + int(random.uniform(0.1, 0.6) * length)


def altered(kind, values, forces, random):
    """Altered readings, the forces that belong to them, the first sample of the fault, and what happened in words."""
    rest = values[:round(REST * RATE)].mean(axis=0)
    change = np.abs(values - rest).max(axis=0)
    at = begin_of_fault(forces, random)
    channel = random.choice(np.flatnonzero(np.abs(values[at:] - rest).max(axis=0) > 0.2 * change.max()))
    out = values.copy()
    text = f"c{channel + 1}"
    if kind == "dead":
        out[at:, channel] = 0
    elif kind == "stuck":
        out[at:, channel] = values[at - 1, channel]
    elif kind == "jump":
        size = random.choice([-1, 1]) * random.uniform(2, 20)
        out[at:, channel] += size
        text += f" {size:+.1f} kPa"
    elif kind == "saturated":
        limit = rest[channel] + random.uniform(0.1, 0.5) * change[channel]
        out[:, channel] = np.minimum(values[:, channel], limit)
        at = int(np.argmax(values[:, channel] > limit))
        text += f" at {limit - rest[channel]:.1f} kPa"
    elif kind == "swapped":
        other = random.choice([k for k in range(values.shape[1]) if k != channel])
        out[at:, [channel, other]] = values[at:, [other, channel]]
        text += f" and c{other + 1}"
    elif kind == "drift":
        rate = random.choice([-1, 1]) * random.uniform(0.5, 5)
        out[at:, channel] += rate * np.arange(len(values) - at) / RATE
        text += f" {rate:+.1f} kPa/s"
    elif kind == "frozen":
        out[at:] = values[at - 1]
        text = "all"
    else:
        return values[at:], forces[at:], 0, "all"
    return out, forces, at, text


def felt(folder, scene, values, forces, at):
    (folder / "pad.yaml").write_text(scene, encoding="ascii")
    runners.write_table(folder / "altered.csv", ["t", *(f"c{k + 1} [kPa]" for k in range(values.shape[1]))],
                        ([f"{k / RATE:.2f}", *(f"{x:.4f}" for x in row)] for k, row in enumerate(values)))
    states = [(round(float(row["t"]) * RATE), row) for row in runners.process(folder / "pad.yaml", folder / "out")]
    # The force of a state is that of the object on the pad.
    estimates = [Estimate(runners.vector(row), tuple(-forces[k]), float(row["sigma"] or "nan"), row["validity"], row["check"])
                 for k, row in states if k >= at + SETTLED * RATE]
    return campaign.compared(estimates, TOUCHES, MAX_ERROR, SIGMAS, np.linalg.norm(forces, axis=1).max())


def cases(options):
    scene = SCENE.format(taxels=options.taxels, network=trained(options))
    for k in range(UNALTERED):
        values, forces = press(options.taxels, 5000 + 100 * options.seed + k)
        yield Case(f"unaltered {k}", lambda folder, one=(values, forces, 0): felt(folder, scene, *one), "unaltered")
    random = np.random.default_rng(options.seed)
    for k in range(options.count):
        kind = KINDS[k % len(KINDS)]
        *one, text = altered(kind, *press(options.taxels, 6000 + 1000 * options.seed + k), random)
        yield Case(f"{kind} {text}", lambda folder, one=one: felt(folder, scene, *one), kind)


def demands(results, options):
    faulty = [outcome for case, outcome in results if case.group != "unaltered"]
    silent = sum(outcome.counts["silent"] > 0 for outcome in faulty)
    yield f"{silent} of {len(faulty)} trials with silent errors, {campaign.share(silent, len(faulty))}; {options.taxels} taxels", silent == 0
    unaltered = [outcome.counts for case, outcome in results if case.group == "unaltered"]
    flagged, touching = (sum(sum(counts[word] for word in words) for counts in unaltered) for words in (["flagged"], campaign.VERDICTS))
    yield f"{flagged} of {touching} contact states flagged without a fault", flagged <= MAX_FLAGGED * touching
