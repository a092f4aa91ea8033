// Cases with faults of lens, sensor, shutter and link, and with objects that enter the view, for
// one camera and for a pair. The requirements were written before the first run.
#include <utility>

#include <Eigen/Geometry>

#include "tests/campaigns/robustness/case.h"
#include "tests/campaigns/robustness/damage.h"
#include "tests/campaigns/robustness/severities.h"

namespace palpate::robustness {
namespace {

Alteration Stale(Mask mask) {
  Alteration alteration;
  alteration.stale = std::move(mask);
  return alteration;
}

void AddLens(CaseTable* table) {
  table->Add("lens smudged over the contact", "px of blur", {2}, {5},
             [](double s) { return Smudge(s, 0.1); });
  table->Add("smudge comes at rest", "px of blur", {2}, {5},
             [](double s) { return From(When::kAtRest, Smudge(s, 0.1)); });
  table->Add("veil over the contact", "%", {30}, {70},
             [](double s) { return Smudge(0.5, s / 100); });
  table->Add("haze rises", "%", {30}, {80}, [](double s) { return Haze(s / 100); });
  table->Add("dust", "specks", {20}, {150}, [](double s) { return Dust(static_cast<int>(s)); });
  table->Add("focus breathes", "%", {}, {1, 3}, [](double s) { return Breathing(1 + s / 100); });
  table->Add("loses focus", "px", {1}, {4}, [](double s) { return LoseFocus(s); });
  table->Add("over-exposed at rest", "%", {}, {100, 200},
             [](double s) { return From(When::kAtRest, Gain(1 + s / 100)); });
  table->Add("gamma changes while pressed", "", {0.8}, {0.4, 2.5},
             [](double s) { return From(When::kPressed, Gamma(s)); });
  table->Add("gain steps while pressed", "%", {30}, {-70, 100},
             [](double s) { return From(When::kPressed, Gain(1 + s / 100)); });
}

void AddSensor(CaseTable* table) {
  table->Add("rows wobble", "px", {0.5}, {2, 6}, [](double s) { return Wobble(s); });
  table->Add("every other row aside", "px", {1}, {4}, [](double s) { return Comb(s); });
  table->Add("rows dead at the contact", "rows", {1}, {4},
             [](double s) { return DeadRows(static_cast<int>(s), 0); });
  table->Add("columns dead at the contact", "columns", {1}, {4},
             [](double s) { return DeadColumns(static_cast<int>(s), 0); });
  table->Add("hot pixels", "per mille", {1}, {30}, [](double s) { return HotPixels(s / 1000); });
  table->Add("banding", "%", {10}, {40}, [](double s) { return Banding(s / 100); });
  table->Add("grey levels left", "", {32}, {6},
             [](double s) { return Quantised(static_cast<int>(s)); });
  table->Add("inverted from rest on", Demand::kFlag, {.paint = From(When::kAtRest, Inverted())});
}

void AddLine(CaseTable* table) {
  for (const Part part : {Part::kUpper, Part::kLower}) {
    const std::string name = part == Part::kUpper ? "upper" : "lower";
    table->Add(name + " part old", "%", {}, {30, 50, 80},
               [=](double s) { return Stale(PartlyOld(part, s / 100)); });
    table->Add(name + " part grey while pressed", "%", {}, {30, 50, 80},
               [=](double s) { return From(When::kPressed, PartlyGrey(part, s / 100)); });
  }
  table->Add("blocks lost", "%", {}, {2, 10, 30},
             [](double s) { return Stale(BlocksLost(s / 100)); });
  table->Add("mirrored from rest on", Demand::kFlag, {.paint = From(When::kAtRest, Mirrored(1))});
  table->Add("upside down from rest on", Demand::kFlag,
             {.paint = From(When::kAtRest, Mirrored(0))});
  table->Add("mirrored", Demand::kFlag, {.paint = Mirrored(1)});
  table->Add("of another size from rest on", Demand::kFlag,
             {.paint = From(When::kAtRest, Resized(0.5))});
  table->Add("of another size", Demand::kFlag, {.paint = Resized(0.5)});
}

void AddCompany(CaseTable* table) {
  table->Add("a second tool", "px aside", {}, {60, 25, 120},
             [](double s) { return SecondTool(s); });
  table->Add("a second tool comes while pressed", "px aside", {}, {25, 60},
             [](double s) { return From(When::kPressed, SecondTool(s)); });
  table->Add("something beside the tool", "px away", {}, {30, 10},
             [](double s) { return From(When::kAtRest, Neighbour(s)); });
  table->Add("a wire wanders", "px", {2}, {6}, [](double s) { return MovingWire(s); });
}

void AddWrongParameters(CaseTable* table) {
  table->Add("tool's width stated wrong", "%", {}, {-20, 20}, [](double s) {
    return AlterScene([s](Scene& scene) { scene.tool->width *= 1 + s / 100; });
  });
  table->Add("camera turned against the scene", "deg", {}, {3, 10}, [](double s) {
    return AlterScene([s](Scene& scene) {
      scene.sense.Find<Camera>()->X_SC.rotate(
          Eigen::AngleAxisd(s * M_PI / 180, Eigen::Vector3d::UnitZ()));
    });
  });
  table->Add("the arm says too deep", "px", {}, {2, 5}, [](double s) {
    Alteration alteration;
    alteration.arm_error = -s;
    return alteration;
  });
}

void AddForTwo(CaseTable* table) {
  table->Add("one eye too low", "px", {}, {1, 3}, [](double s) {
    return OnSide(1, Bump({0, s}, When::kAlways));
  });
  table->Add("one eye aside", "px", {}, {1, 3}, [](double s) {
    return OnSide(1, Bump({s, 0}, When::kAlways));
  });
  table->Add("one eye's gain steps while pressed", "%", {30}, {-60, 100},
             [](double s) { return OnSide(0, From(When::kPressed, Gain(1 + s / 100))); });
  table->Add("sides swapped from rest on", Demand::kFlag, {.swapped = When::kAtRest});
  table->Add("sides swapped while pressed", Demand::kFlag, {.swapped = When::kPressed});
  table->Add("one eye mirrored from rest on", Demand::kFlag,
             {.paint = OnSide(1, From(When::kAtRest, Mirrored(1)))});
  table->Add("one eye smudged", "px of blur", {1}, {4},
             [](double s) { return OnSide(0, Smudge(s, 0.1)); });
  table->Add("both zoomed at rest", "%", {}, {0.5, 2},
             [](double s) { return Zoom(1 + s / 100, When::kAtRest); });
  table->Add("rig turned at rest", "deg", {}, {0.5, 2},
             [](double s) { return Turn(s, When::kAtRest); });
  table->Add("one eye partly old", "%", {}, {50, 80},
             [](double s) { return Stale(PartlyOld(Part::kLower, s / 100, 1)); });
  table->Add("both partly old", "%", {}, {50, 80},
             [](double s) { return Stale(PartlyOld(Part::kLower, s / 100)); });
  table->Add("every other row aside", "px", {1}, {4}, [](double s) { return Comb(s); });
  table->Add("rows wobble", "px", {}, {0.5, 2}, [](double s) { return Wobble(s); });
  table->Add("hot pixels", "per mille", {1}, {30}, [](double s) { return HotPixels(s / 1000); });
  table->Add("rows dead", "rows", {2}, {8},
             [](double s) { return DeadRows(static_cast<int>(s), 0); });
  table->Add("dust", "specks", {20}, {150}, [](double s) { return Dust(static_cast<int>(s)); });
  table->Add("grey levels left", "", {32}, {6},
             [](double s) { return Quantised(static_cast<int>(s)); });
  table->Add("barrel distortion of one eye", "px", {}, {2, 6},
             [](double s) { return OnSide(1, Barrel(s)); });
  table->Add("over-exposed", "%", {}, {60, 200}, [](double s) { return Gain(1 + s / 100); });
  table->Add("blocks lost", "%", {}, {2, 10}, [](double s) { return Stale(BlocksLost(s / 100)); });
}

// Cases added after the others passed; most are similar to them.
void AddLaterForTwo(CaseTable* table) {
  table->Rarely(true);
  table->Add("gamma changes while pressed", "", {0.8}, {0.4, 2.5},
             [](double s) { return From(When::kPressed, Gamma(s)); });
  table->Add("banding", "%", {10}, {40}, [](double s) { return Banding(s / 100); });
  table->Add("haze rises", "%", {30}, {80}, [](double s) { return Haze(s / 100); });
  table->Add("lamp moves while pressed", "% to one side", {20}, {60},
             [](double s) { return From(When::kPressed, OneSided(s / 100)); });
  table->Add("a hand comes", "px beyond the middle", {}, {-60, 0, 60},
             [](double s) { return Hand(s, When::kPressed); });
  table->Add("focus breathes", "%", {}, {0.5, 2}, [](double s) { return Breathing(1 + s / 100); });
  table->Add("rig turns slowly", "deg", {}, {1, 4}, [](double s) { return TurnSlowly(s); });
  table->Add("zoomed from the start", "%", {}, {-2, 2},
             [](double s) { return Zoom(1 + s / 100, When::kAlways); });
  table->Add("one eye zoomed from the start", "%", {}, {0.5, 2},
             [](double s) { return OnSide(1, Zoom(1 + s / 100, When::kAlways)); });
  table->Add("cut out elsewhere", "px", {}, {2, 8}, [](double s) {
    return Bump({s, s}, When::kAlways);
  });
  table->Add("an old pair now and then", "pairs ago", {}, {3, 12}, [](double s) {
    Alteration alteration;
    alteration.shows = NowAndThenOld(static_cast<std::size_t>(s));
    return alteration;
  });
  table->Rarely(false);
}

// Cases for one camera and for two. They were first counted with the checks of that time, none of
// which was made for them.
void AddUnseen(CaseTable* table) {
  table->Rarely(true);
  table->Add("rain", "streaks", {20}, {150}, [](double s) { return Rain(static_cast<int>(s)); });
  table->Add("a drop on the lens", "px of pull", {}, {1, 3, 8},
             [](double s) { return Droplet(s); });
  table->Add("fog over one half", "%", {30}, {70}, [](double s) { return Fog(s / 100); });
  table->Add("gain rolls through", "%", {15}, {50}, [](double s) { return RollingGain(s / 100); });
  table->Add("rows stuck below the contact", "rows", {2}, {8, 20},
             [](double s) { return StuckRows(static_cast<int>(s)); });
  table->Add("moire", "grey levels", {10}, {40}, [](double s) { return Moire(s); });
  table->Add("clusters of dead pixels", "clusters", {15}, {150},
             [](double s) { return DeadClusters(static_cast<int>(s)); });
  table->Add("an insect crawls past", "px", {3}, {8, 16}, [](double s) { return Insect(s); });
  table->Add("ghost in the glass", "%", {10}, {40}, [](double s) { return Ghost(s / 100); });
  table->Add("hot air", "px", {0.3}, {1, 3}, [](double s) { return HeatHaze(s); });
  table->Rarely(false);
}

}  // namespace

void AddCameraDamage(CaseTable* table) {
  AddLens(table);
  AddSensor(table);
  AddLine(table);
  AddCompany(table);
  AddWrongParameters(table);
  AddUnseen(table);
}

void AddPairDamage(CaseTable* table) {
  AddForTwo(table);
  AddLaterForTwo(table);
  AddUnseen(table);
}

}  // namespace palpate::robustness
