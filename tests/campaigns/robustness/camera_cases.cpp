// Disturbances that one camera must tolerate, and those under which it may flag a force.
#include <cmath>
#include <numbers>
#include <variant>

#include <Eigen/Geometry>

#include "tests/campaigns/robustness/case.h"
#include "tests/campaigns/robustness/severities.h"

namespace palpate::robustness {
namespace {

using Eigen::Vector2d;

void AddLight(CaseTable* table) {
  table->Add("flicker", "%", {10, 20}, {40}, [](double s) { return Flicker(s / 100); });
  table->Add("vignette", "%", {10, 20}, {50}, [](double s) { return Vignette(s / 100); });
  table->Add("darker", "%", {20}, {60}, [](double s) { return Gain(1 - s / 100); });
  table->Add("brighter", "%", {20}, {60}, [](double s) { return Gain(1 + s / 100); });
  table->Add("gamma", "", {0.8, 1.3}, {0.5, 2}, [](double s) { return Gamma(s); });
  table->Add("a lamp goes off at rest", "%", {20}, {50},
             [](double s) { return From(When::kAtRest, Gain(1 - s / 100)); });
  table->Add("shadow over tool and object", "%", {30}, {50, 80},
             [](double s) { return Shadow(s / 100); });
  table->Add("glint on the tip", "px", {2}, {4, 8}, [](double s) { return GlintOnTip(s); });
  table->Add("glint on the shaft - moving", "px", {2, 4}, {8},
             [](double s) { return GlintOnShaft(s, 20); });
  table->Add("glint on the shaft - standing", "px", {2, 4}, {8},
             [](double s) { return GlintStanding(s, 20); });
  table->Add("glint beside the contact", "px", {2, 4}, {8}, [](double s) {
    return [s](const View& view, cv::Mat& image) {
      View beside = view;
      beside.shaft_I = {-view.shaft_I.y(), view.shaft_I.x()};
      GlintStanding(s, view.width)(beside, image);
    };
  });
}

void AddOccluders(CaseTable* table) {
  for (const int degrees : {0, 30, 60, 90, 120, 150}) {
    table->Add("wire over the shaft at " + std::to_string(degrees) + " deg", "px", {2}, {4},
               [=](double s) { return Wire(s, degrees, 15); });
  }
  table->Add("wire through the tip at 20 deg", "px", {2}, {4},
             [](double s) { return Wire(s, 20, 0); });
  table->Add("bright wire over the shaft at 45 deg", "px", {2}, {4},
             [](double s) { return Wire(s, 45, 15, 230); });
  table->Add("wire over the object at 10 deg", "px", {2}, {4},
             [](double s) { return Wire(s, 10, -20); });
  table->Add("side of the tool covered", "%", {33}, {50, 80},
             [](double s) { return CoveredSide(s / 100); });
  table->Add("piece of the shaft covered - standing", "px", {8}, {16, 32},
             [](double s) { return CoveredPiece(12, 12 + s); });
  table->Add("tip covered - standing", "px", {}, {6, 20},
             [](double s) { return CoveredPiece(-s, s); });
  table->Add("a hand comes and stays", "px", {}, {-30, 0, 30},
             [](double s) { return Hand(s, When::kAtRest); });
  table->Add("a hand comes while pressed and stays", "px", {}, {-30, 0, 30},
             [](double s) { return Hand(s, When::kPressed); });
}

void AddBlur(CaseTable* table) {
  table->Add("defocus", "px", {1, 2}, {4}, [](double s) { return Defocus(s); });
  table->Add("defocus while pressed", "px", {2}, {4},
             [](double s) { return From(When::kPressed, Defocus(s)); });
  table->Add("motion blur along x", "px", {3, 7}, {15}, [](double s) { return MotionBlur(s, 0); });
  table->Add("motion blur along y", "px", {3, 7}, {15}, [](double s) { return MotionBlur(s, 90); });
  table->Add("noise", "grey levels", {8, 15}, {30}, [](double s) { return Noise(s); });
  table->Add("JPEG", "quality", {50, 10}, {4}, [](double s) { return Jpeg(static_cast<int>(s)); });
}

Alteration Moved(double px, double degrees, When when) {
  const double angle = degrees * std::numbers::pi / 180;
  const Vector2d by(std::round(px * std::cos(angle)), std::round(px * std::sin(angle)));
  Alteration alteration;
  alteration.object_moves = [=](const Moment& moment) -> Vector2d {
    return IsSo(when, moment) ? by : Vector2d(0, 0);
  };
  return alteration;
}

void AddMotion(CaseTable* table) {
  table->Add("camera bumped at rest - x", "px", {5, 20}, {40}, [](double s) {
    return Bump({s, 0}, When::kAtRest);
  });
  table->Add("camera bumped at rest - y", "px", {5, 20}, {40}, [](double s) {
    return Bump({0, s}, When::kAtRest);
  });
  table->Add("camera bumped while pressed", "px", {5, 20}, {40}, [](double s) {
    return Bump({s * std::numbers::sqrt2 / 2, s * std::numbers::sqrt2 / 2}, When::kPressed);
  });
  table->Add("camera shakes", "px", {0.5, 2}, {5}, [](double s) { return Shake(s); });
  table->Add("camera drifts", "px", {5, 20}, {40}, [](double s) {
    return Drift({0.6 * s, -0.8 * s});
  });
  table->Add("camera turned at rest", "deg", {}, {1, 4},
             [](double s) { return Turn(s, When::kAtRest); });
  table->Add("zoom changed at rest", "%", {}, {1, 3, 10},
             [](double s) { return Zoom(1 + s / 100, When::kAtRest); });
  table->Add("barrel distortion not in the scene", "px", {}, {2, 10},
             [](double s) { return Barrel(s); });
  table->Add("object moved at rest - away", "px", {5, 20}, {40},
             [](double s) { return Moved(s, 90, When::kAtRest); });
  table->Add("object moved at rest - nearer", "px", {5}, {10},
             [](double s) { return Moved(-s, 90, When::kAtRest); });
  table->Add("object moved at rest - across", "px", {5, 20}, {40},
             [](double s) { return Moved(s, 0, When::kAtRest); });
  table->Add("object moved while pressed", "px", {3}, {10, 20},
             [](double s) { return Moved(s, 90, When::kPressed); });
  table->Add("object drifts", "px", {5}, {20}, [](double s) {
    Alteration drifts;
    drifts.object_moves = [s](const Moment& moment) {
      return Vector2d(0, std::round(s * moment.share()));
    };
    return drifts;
  });
}

void AddTime(CaseTable* table) {
  table->Add("images come twice", Demand::kFlag, Shows(Doubled()));
  table->Add("frozen from rest on", Demand::kFlag, Shows(Frozen(When::kAtRest)));
  table->Add("frozen while pressed", Demand::kFlag, Shows(Frozen(When::kPressed)));
  table->Add("late", "images", {}, {1, 5},
             [](double s) { return Shows(Late(static_cast<std::size_t>(s))); });
  table->Add("lost", "in 20", {1}, {6}, [](double s) {
    Alteration alteration;
    alteration.loses = [s](const Moment& moment) {
      return moment.index > 0 && moment.index * 7 % 20 < static_cast<std::size_t>(s);
    };
    return alteration;
  });
}

// Scales the object's outline about its centre.
void Scale(double factor, Geometry* geometry) {
  if (auto* box = std::get_if<RectangleGeometry>(geometry)) {
    box->width *= factor;
    box->height *= factor;
  } else if (auto* disc = std::get_if<DiscGeometry>(geometry)) {
    disc->radius *= factor;
  }
}

void AddGeometry(CaseTable* table) {
  table->Add("pixel size wrong", "%", {}, {-5, -2, 2, 5}, [](double s) {
    return AlterScene([s](Scene& scene) { scene.sense.Find<Camera>()->pixel *= 1 + s / 100; });
  });
  table->Add("outline wrong", "%", {}, {-5, 5}, [](double s) {
    return AlterScene([s](Scene& scene) { Scale(1 + s / 100, &scene.object.geometry); });
  });
  table->Add("object elsewhere than stated", "px", {5}, {20, 60}, [](double s) {
    return AlterScene([s](Scene& scene) {
      scene.object.X_SO.translation().x() += s * scene.sense.Find<Camera>()->pixel;
    });
  });
  table->Add("object turned against the scene", "deg", {}, {3, 10}, [](double s) {
    return AlterScene([s](Scene& scene) {
      scene.object.X_SO.rotate(
          Eigen::AngleAxisd(s * std::numbers::pi / 180, Eigen::Vector3d::UnitZ()));
    });
  });
  table->Add("tool's direction wrong", "deg", {}, {5, 20, 90}, [](double s) {
    return AlterScene([s](Scene& scene) {
      scene.tool->direction =
          Eigen::Rotation2Dd(s * std::numbers::pi / 180) * scene.tool->direction;
    });
  });
  table->Add("the arm's report wrong", "px", {}, {2, 10}, [](double s) {
    Alteration alteration;
    alteration.arm_error = s;
    return alteration;
  });
}

void AddMixtures(CaseTable* table) {
  table->Add("noise 8 + defocus 1 + flicker 10", Demand::kRight,
             {.paint = All({Defocus(1), Flicker(0.1), Noise(8)})});
  table->Add("shadow 30 + JPEG 30 + glint 3", Demand::kRight,
             {.paint = All({GlintOnShaft(3, 15), Shadow(0.3), Jpeg(30)})});
  table->Add("wire 3 + bump 10 + noise 10", Demand::kFlag,
             {.paint = All({Wire(3, 70, 10), Bump({7, -7}, When::kAtRest), Noise(10)})});
  table->Add("shake 1 + vignette 20 + motion blur 5", Demand::kFlag,
             {.paint = All({Shake(1), Vignette(0.2), MotionBlur(5, 30)})});
}

}  // namespace

std::vector<Case> CameraCases() {
  CaseTable table;
  table.Add("undisturbed", Demand::kRight, {});
  AddLight(&table);
  AddOccluders(&table);
  AddBlur(&table);
  AddMotion(&table);
  AddTime(&table);
  AddGeometry(&table);
  AddMixtures(&table);
  AddCameraDamage(&table);
  return table.Take();
}

}  // namespace palpate::robustness
