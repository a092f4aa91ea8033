"""Ten kinds of webcam set-ups, through the modules of the page and the slave. References are independent finite elements and images.

Each set-up is rendered, set up by a simulated person with inexact clicks, and processed. Where the page asks for a strip of tape or
another height of the camera, the person follows it once. A state in contact is silent if it is valid and off by more than 10 % of
the peak; at most 1 % of them are accepted. Needs NumPy, SciPy, Gmsh, Pillow and Node.js.
"""
import functools
import json
import math
import os
import pathlib
import shutil

import numpy as np
from PIL import Image

import campaign
import runners
from campaign import Case, Estimate, verdict
from truth.render import Stage
from truth.setups import KINDS, RATE, Setup

COUNT = 30
PERSON = pathlib.Path(__file__).resolve().parent / "webcam"
MIN_CONTACT_FORCE, MAX_VALID_ERROR = 0.02, 0.10  # relative to the peak: smallest force of a state in contact; largest error of a valid force
MAX_SILENT = 0.01  # of the valid states in contact


def arguments(parser):
    parser.add_argument("--first", type=int, default=0, help="number of the first set-up, which draws it")
    parser.add_argument("--browser", action="store_true", help="through the page in Chromium, where tests/page/run.sh has run")
    parser.add_argument("--faults", action="store_true", help="damaged sequences of one set-up in place of all set-ups")


def rendered(setup, number, folder):
    """Writes images, true forces and the person's input of a set-up to `folder`."""
    if (folder / "setup.json").exists():
        known = json.loads((folder / "setup.json").read_text())
        (folder / "setup.json").write_text(json.dumps({**known, **setup.clicks(number)}))
        return
    frames = folder / "frames"
    frames.mkdir(parents=True, exist_ok=True)
    tips, press = setup.press()
    stage = Stage(setup, np.random.default_rng(number))
    with open(folder / "truth.csv", "w") as file:
        file.write("force\n" + "".join(f"{force:.9g}\n" for force, _ in press))
    for i, (tip, (_, outline), gain) in enumerate(zip(tips, press, setup.gains(len(tips)))):
        (frames / f"{i:06d}.jpg").write_bytes(stage.image(tip, outline, gain))
    first = Image.open(frames / "000000.jpg").convert("RGBA")
    (folder / "frozen.rgba").write_bytes(first.tobytes())
    known = {**setup.clicks(number), "size": first.size, "first": "frames/000000.jpg", "remedies": setup.remedies}
    (folder / "setup.json").write_text(json.dumps(known))


def set_up_in_modules(folder):
    """Runs the page's modules on the set-up in `folder`. Returns their result."""
    images = folder / "frames/%06d.jpg"
    width, height = json.loads((folder / "setup.json").read_text())["size"]
    lines = f'file: "{images}"\nrate: {RATE} Hz\nsize: [{width}, {height}]\n'
    with runners.Serving("listening on ", runners.SLAVE, "serve", "--setup", folder / "kept", "--camera", images, "--camera-rate", RATE,
                         "--listen", "127.0.0.1:0") as slave:
        with runners.Serving("view at ", runners.MASTER, "connect", slave.address, "--device", "pointer", "--view", "127.0.0.1:0") as master:
            return json.loads(runners.run("node", PERSON / "set_up.mjs", folder, master.address.rstrip("/"), lines).stdout)


def set_up_in_browser(folder):
    """Does the same with the page in Chromium, with the packages of tests/page/run.sh."""
    shutil.rmtree(folder / "browser", ignore_errors=True)
    environment = {**os.environ, "PALPATE_BIN": str(runners.BIN), "PALPATE_SCRATCH": str(runners.ROOT / "build/page")}
    run = runners.run("node", PERSON / "browser.mjs", folder, env=environment)
    return {"edgePx": float("nan"), "tipPx": float("nan"), **json.loads(run.stdout.splitlines()[-1])}


def compared(rows, truth, result):
    """Compares the magnitudes of the forces with the true ones."""
    estimates = [Estimate((campaign.size(runners.vector(row)),), (force,), float(row["sigma"] or "nan"), row["validity"], row.get("check", ""))
                 for row, force in zip(rows, truth)]
    outcome = campaign.compared(estimates, MIN_CONTACT_FORCE, MAX_VALID_ERROR)
    outcome.text += f"; edge {result['edgePx']:.2f} px, tip {result['tipPx']:.2f} px"
    outcome.values["free_sigma_0"] = sum(one.validity == "valid" and one.truth == (0,) and one.sigma == 0 for one in estimates)
    return outcome


def remedy_of(words):
    """Returns the remedy that a message of the page requests."""
    text = " ".join(words)
    return "tape" if "strip of tape" in text else "sheet" if "plain sheet" in text else \
        "height" if "height of the" in text else "middle" if "in the middle of the image" in text else \
        "near" if "mm above the object" in text else None


def tried(number, set_up, folder):
    """Runs a set-up, and again each time the page's advice is followed."""
    remedies = []
    while True:
        own = folder / "-".join([str(number), *remedies])
        rendered(Setup(number, remedies), number, own)
        result = set_up(own)
        if "done" in result:
            scene = own / ("saved/scene.yaml" if set_up is set_up_in_modules else "browser/scene.yaml")
            outcome = compared(runners.process(scene, own / "out"), np.loadtxt(own / "truth.csv", skiprows=1), result)
        else:
            outcome = verdict("refused", f"at {result.get('step')}: {' '.join(result.get('words', []))}")
        outcome.text += f"; after {', '.join(remedies)}" if remedies else ""
        remedy = remedy_of(result.get("words", []))
        if remedy is None or remedy in remedies:
            return outcome
        remedies.append(remedy)


def damaged(count, rng):
    """Returns damaged sequences by name: for each image the number of the true image that it shows, and the gain of its
    exposure."""
    whole, plain = np.arange(count), np.ones(count)
    kept = np.sort(rng.choice(whole[1:], int(0.8 * count), replace=False))
    doubled, late = whole.copy(), whole.copy()
    doubled[5::5] = doubled[4:-1:5][:len(doubled[5::5])]
    for start in rng.choice(np.arange(3, count - 3), 6, replace=False):
        late[start:start + 2] = late[start - 1]
    step = np.arange(count) > count // 3
    return {"dropped": (np.concatenate([[0], kept]), plain[:len(kept) + 1]), "doubled": (doubled, plain), "late": (late, plain),
            "exposure x 0.7": (whole, np.where(step, 0.7, 1.0)), "exposure x 1.4": (whole, np.where(step, 1.4, 1.0)),
            "exposure x 0.4": (whole, np.where(step, 0.4, 1.0))}


def set_up_for_faults(folder):
    """Sets up one scene at 1280 x 720. Returns what the page says of it, and the true forces."""
    rendered(Setup(0, size=(1280, 720)), 0, folder)
    result = set_up_in_modules(folder)
    if "done" not in result:
        raise campaign.Refused(f"at {result.get('step')}: {' '.join(result.get('words', []))}")
    return result, np.loadtxt(folder / "truth.csv", skiprows=1)


def processed_damaged(whole, result, truth, name, shown, gains, folder):
    """Processes a damaged sequence of the set-up in `whole`. Compares each image with the true force at its time."""
    for i, (number, gain) in enumerate(zip(shown, gains)):
        image = Image.open(whole / f"frames/{number:06d}.jpg").point(lambda level, gain=gain: min(255, gain * level))
        image.save(folder / f"{i:06d}.jpg", quality=95)
    scene = whole / f"saved/{name.replace(' ', '-')}.yaml"
    scene.write_text((whole / "saved/scene.yaml").read_text().replace(str(whole / "frames"), str(folder)))
    # A dropped image leaves a gap. A late or doubled one is replaced by the previous image.
    return compared(runners.process(scene, folder / "out"), truth[shown] if name == "dropped" else truth, result)


def cases(options):
    if options.faults:
        whole = options.folder / "whole"
        result, truth = set_up_for_faults(whole)
        for name, (shown, gains) in damaged(len(truth), np.random.default_rng(1)).items():
            yield Case(name, functools.partial(processed_damaged, whole, result, truth, name, shown, gains), "faults")
        return
    set_up = set_up_in_browser if options.browser else set_up_in_modules
    for number in range(options.first, options.first + options.count):
        kind = KINDS[number % len(KINDS)]
        yield Case(f"{number} {kind}", functools.partial(tried, number, set_up), kind)


def demands(results, options):
    reached = [outcome for _, outcome in results if outcome.values.get("valid")]
    yield f"{len(reached)} of {len(results)} reached a force", True
    silent = sum(outcome.counts["silent"] for outcome in reached)
    valid, one, two, free = (sum(outcome.values[key] for outcome in reached) for key in ("valid", "one", "two", "free_sigma_0"))
    yield f"{silent} of {valid} valid contact states are off by more than 10 % of the peak", silent <= (0 if options.faults else MAX_SILENT * valid)
    rms = math.sqrt(np.mean([outcome.values["valid_rms"] ** 2 for outcome in reached])) if reached else math.nan
    yield (f"rms {100 * rms:.1f} %; within one and two sigma {100 * one / max(1, valid):.0f}, {100 * two / max(1, valid):.0f} %; {free} valid "
           "states without contact have a sigma of 0"), True
