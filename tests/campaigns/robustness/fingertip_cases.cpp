// Disturbances that fingertips must tolerate, and those under which they may flag a force.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <spdlog/fmt/fmt.h>

#include "tests/campaigns/robustness/case.h"
#include "tests/campaigns/robustness/severities.h"

namespace palpate::robustness {
namespace {

constexpr double kNoise = 0.87;  // of a simulated electrode, one sigma [counts]

using Change = std::function<void(const Moment&, TactileFrame&)>;

Alteration Reads(Change change) {
  Alteration alteration;
  alteration.touch = std::move(change);
  return alteration;
}
// Applies `each` to the reading of every finger that is present.
template <typename Each>
Change OfEach(const Each& each) {
  return [each](const Moment& moment, TactileFrame& frame) {
    for (std::size_t f = 0; f < frame.fingers.size(); ++f) {
      if (frame.fingers[f].present) each(moment, f, frame.fingers[f]);
    }
  };
}
Change OfFirst(const std::function<void(const Moment&, FingerReading&)>& change) {
  return [change](const Moment& moment, TactileFrame& frame) { change(moment, frame.fingers[0]); };
}

// Keeps the reading of the first sample of a run, which gives the rest values.
class Rest {
 public:
  const FingerReading& Of(const Moment& moment, std::size_t finger, const FingerReading& now) {
    if (moment.index == 0 || !first_.contains(finger)) first_[finger] = now;
    return first_[finger];
  }

 private:
  std::map<std::size_t, FingerReading> first_;
};

// Multiplies the distance of electrodes and pressure from their values at rest by `factor`.
Alteration Amplified(std::function<double(const Moment&)> factor) {
  return Reads(OfEach([factor = std::move(factor), rest = std::make_shared<Rest>()](
                          const Moment& moment, std::size_t f, FingerReading& reading) {
    const FingerReading& from = rest->Of(moment, f, reading);
    const auto gain = static_cast<float>(factor(moment));
    for (std::size_t e = 0; e < reading.channels.size(); ++e) {
      reading.channels[e] = from.channels[e] + gain * (reading.channels[e] - from.channels[e]);
    }
    reading.pdc = from.pdc + gain * (reading.pdc - from.pdc);
  }));
}

// From `when` on, the electrodes keep their last value. Their numbers begin at 0.
Alteration Stuck(std::vector<std::size_t> electrodes, When when) {
  return Reads(OfFirst(
      [=, held = std::make_shared<FingerReading>()](const Moment& moment, FingerReading& reading) {
        if (!IsSo(when, moment) || moment.index == 0) *held = reading;
        for (const std::size_t e : electrodes) reading.channels[e] = held->channels[e];
      }));
}

void AddElectrodes(CaseTable* table) {
  for (const std::size_t e : {0U, 6U, 9U, 16U, 18U}) {
    const std::string name = fmt::format("E{}", e + 1);
    table->Add(name + " stuck at rest", Demand::kRight, Stuck({e}, When::kAtRest));
    table->Add(name + " stuck while pressed", Demand::kRight, Stuck({e}, When::kPressed));
  }
  table->Add("three electrodes stuck", Demand::kFlag, Stuck({2, 9, 16}, When::kAtRest));
  table->Add(
      "all electrodes stuck while pressed", Demand::kFlag,
      Stuck({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18}, When::kPressed));
  table->Add("an electrode reads nothing", Demand::kRight,
             Reads(OfFirst([](const Moment& moment, FingerReading& reading) {
               if (IsSo(When::kAtRest, moment)) reading.channels[9] = 0;
             })));
  table->Add("an electrode reads full", Demand::kRight,
             Reads(OfFirst([](const Moment& moment, FingerReading& reading) {
               if (IsSo(When::kAtRest, moment)) reading.channels[16] = 4095;
             })));
  table->Add("two electrodes swapped", Demand::kFlag,
             Reads(OfEach([](const Moment&, std::size_t, FingerReading& reading) {
               std::swap(reading.channels[6], reading.channels[16]);
             })));
  table->Add("electrodes in reverse order", Demand::kFlag,
             Reads(OfEach([](const Moment&, std::size_t, FingerReading& reading) {
               std::ranges::reverse(reading.channels);
             })));
  table->Add("noise", "times", {2, 3}, {10}, [](double s) {
    return Reads(OfEach([s](const Moment& moment, std::size_t f, FingerReading& reading) {
      std::mt19937_64 random(1000 * moment.index + f);
      std::normal_distribution<double> normal(0, kNoise * std::sqrt(s * s - 1));
      for (float& e : reading.channels) e += static_cast<float>(normal(random));
      reading.pdc += static_cast<float>(normal(random));
    }));
  });
  table->Add("rest drifts", "counts", {5, 10}, {40}, [](double s) {
    return Reads(OfEach([s](const Moment& moment, std::size_t f, FingerReading& reading) {
      for (std::size_t e = 0; e < reading.channels.size(); ++e) {
        const double sign = (e * 7 + f) % 3 == 0 ? -1 : 1;
        reading.channels[e] += static_cast<float>(sign * s * moment.share());
      }
    }));
  });
  table->Add("warms up", "counts", {10}, {50, 200}, [](double s) {
    return Reads(OfEach([s](const Moment& moment, std::size_t, FingerReading& reading) {
      const auto warm = static_cast<float>(s * (1 - std::exp(-3 * moment.share())));
      for (float& e : reading.channels) e -= warm;
      reading.pdc += 0.5F * warm;
    }));
  });
  table->Add("pressure stuck", Demand::kFlag,
             Reads(OfFirst([held = std::make_shared<float>(0.F)](const Moment& moment,
                                                                 FingerReading& reading) {
               if (!IsSo(When::kAtRest, moment)) *held = reading.pdc;
               reading.pdc = *held;
             })));
  table->Add("gain of all wrong", "%", {}, {-30, -10, 10, 30},
             [](double s) { return Amplified([s](const Moment&) { return 1 + s / 100; }); });
}

void AddSamples(CaseTable* table) {
  table->Add("lost", "%", {2, 5}, {30}, [](double s) {
    Alteration alteration;
    alteration.loses = [s](const Moment& moment) {
      return moment.index > 0 &&
             static_cast<double>(std::mt19937_64(moment.index)() % 1000) < 10 * s;
    };
    return alteration;
  });
  table->Add("late", "samples", {}, {3, 10},
             [](double s) { return Shows(Late(static_cast<std::size_t>(s))); });
  table->Add("doubled", Demand::kFlag, Shows(Doubled()));
  table->Add("frozen from rest on", Demand::kFlag, Shows(Frozen(When::kAtRest)));
  table->Add("frozen while pressed", Demand::kFlag, Shows(Frozen(When::kPressed)));
  table->Add("a finger goes missing while pressed", Demand::kFlag,
             Reads(OfFirst([](const Moment& moment, FingerReading& reading) {
               if (IsSo(When::kPressed, moment)) reading.present = false;
             })));
  table->Add("pressed while rest is taken", Demand::kFlag, Shows([](const Moment& moment) {
               return moment.index < moment.script.way ? moment.script.hold : moment.index;
             }));
}

// One electrode repeats its reading of `samples` before.
Alteration ElectrodeLate(std::size_t electrode, std::size_t samples) {
  return Reads(OfFirst([=, read = std::make_shared<std::vector<float>>()](const Moment& moment,
                                                                          FingerReading& reading) {
    if (moment.index == 0) read->clear();
    read->push_back(reading.channels[electrode]);
    const std::size_t back = std::min(samples, read->size() - 1);
    reading.channels[electrode] = (*read)[read->size() - 1 - back];
  }));
}

// Electrodes as `change` makes them of how far they are from rest [counts].
Alteration EachElectrode(
    std::function<double(const Moment&, std::size_t electrode, double)> change) {
  return Reads(OfEach([change = std::move(change), rest = std::make_shared<Rest>()](
                          const Moment& moment, std::size_t f, FingerReading& reading) {
    const FingerReading& from = rest->Of(moment, f, reading);
    for (std::size_t e = 0; e < reading.channels.size(); ++e) {
      const double away = reading.channels[e] - from.channels[e];
      reading.channels[e] = static_cast<float>(from.channels[e] + change(moment, e, away));
    }
  }));
}

// These were first counted with the checks of that time, none of which was made for them.
void AddUnseen(CaseTable* table) {
  table->Rarely(true);
  table->Add("an electrode is late", "samples", {}, {3, 10},
             [](double s) { return ElectrodeLate(9, static_cast<std::size_t>(s)); });
  table->Add("electrodes in coarse steps", "counts", {2}, {8, 30}, [](double s) {
    return EachElectrode(
        [s](const Moment&, std::size_t, double away) { return s * std::round(away / s); });
  });
  table->Add("electrodes saturate", "counts from rest", {}, {80, 40, 20}, [](double s) {
    return EachElectrode(
        [s](const Moment&, std::size_t, double away) { return std::clamp(away, -s, s); });
  });
  table->Add("gain drifts", "%", {}, {-30, -10, 10, 30}, [](double s) {
    return Amplified([s](const Moment& moment) { return 1 + s / 100 * moment.share(); });
  });
  table->Add("E3 and E12 swap while pressed", Demand::kFlag,
             Reads(OfFirst([](const Moment& moment, FingerReading& reading) {
               if (!IsSo(When::kPressed, moment)) return;
               std::swap(reading.channels[2], reading.channels[11]);
             })));
  for (const When when : {When::kAtRest, When::kPressed}) {
    const std::string name = when == When::kAtRest ? "at rest" : "while pressed";
    table->Add("all electrodes step " + name, "counts", {5}, {20, 60}, [when](double s) {
      return EachElectrode([=](const Moment& moment, std::size_t, double away) {
        return away + (IsSo(when, moment) ? s : 0);
      });
    });
  }
  table->Add("samples come again in bursts", "of 12", {2}, {5, 10}, [](double s) {
    return Shows([s](const Moment& moment) {
      const std::size_t into = moment.index % 12;
      const auto again = static_cast<std::size_t>(s);
      return into >= 12 - again ? moment.index - into + 11 - again : moment.index;
    });
  });
  table->Add("spikes", "counts", {50}, {400}, [](double s) {
    return EachElectrode([s](const Moment& moment, std::size_t e, double away) {
      const auto throws = std::mt19937_64(moment.index * kElectrodeCount + e)() % 200;
      return away + (throws == 0 ? s : throws == 1 ? -s : 0);
    });
  });
  table->Add("hum", "counts", {2}, {10, 40}, [](double s) {
    return EachElectrode([s](const Moment& moment, std::size_t, double away) {
      return away + s * std::sin(1.9 * static_cast<double>(moment.index));
    });
  });
  table->Rarely(false);
}

// As in AddUnseen, these were first counted with the checks of that time.
void AddUnseenToo(CaseTable* table) {
  table->Rarely(true);
  // Each electrode drifts differently, and nothing of it shows at rest.
  table->Add("rest drifts from the touch on", "counts", {}, {5, 10, 40}, [](double s) {
    return EachElectrode([s](const Moment& moment, std::size_t e, double away) {
      std::mt19937_64 random(e);
      const double way = std::normal_distribution<double>(0, s)(random);
      const double left = static_cast<double>(moment.script.count - moment.script.touch);
      const double since =
          static_cast<double>(moment.index) - static_cast<double>(moment.script.touch);
      return away + way * std::max(0.0, since / left);
    });
  });
  table->Add("rest walks", "counts/sample", {}, {0.3, 1}, [](double s) {
    using Walk = std::map<std::pair<std::size_t, std::size_t>, double>;
    return Reads(OfEach([s, walk = std::make_shared<Walk>()](const Moment& moment, std::size_t f,
                                                             FingerReading& reading) {
      if (moment.index == 0) walk->clear();
      for (std::size_t e = 0; e < reading.channels.size(); ++e) {
        std::mt19937_64 random(moment.index * 100 + 20 * f + e);
        double& at = (*walk)[{f, e}];
        at += std::normal_distribution<double>(0, s)(random);
        reading.channels[e] += static_cast<float>(at);
      }
    }));
  });
  table->Add("pressure drifts", "counts", {5}, {20, 100}, [](double s) {
    return Reads(OfEach([s](const Moment& moment, std::size_t, FingerReading& reading) {
      reading.pdc += static_cast<float>(s * moment.share());
    }));
  });
  table->Add("gain of E10", "%", {}, {-50, -20, 20, 50}, [](double s) {
    return EachElectrode([s](const Moment&, std::size_t e, double away) {
      return e == 9 ? away * (1 + s / 100) : away;
    });
  });
  table->Add("a loose contact", "of 20 samples", {}, {3, 10}, [](double s) {
    return EachElectrode([s](const Moment& moment, std::size_t e, double away) {
      return e == 9 && static_cast<double>(moment.index % 20) < s ? 0 : away;
    });
  });
  table->Add("plugged in one off", Demand::kFlag,
             Reads(OfEach([](const Moment&, std::size_t, FingerReading& reading) {
               std::ranges::rotate(reading.channels, reading.channels.begin() + 1);
             })));
  table->Add("fingers swapped", Demand::kFlag, Reads([](const Moment&, TactileFrame& frame) {
               FingerReading& first = frame.fingers.front();
               FingerReading& last = frame.fingers.back();
               std::swap(first.channels, last.channels);
               std::swap(first.pac, last.pac);
               std::swap(first.pdc, last.pdc);
             }));
  // Wet skin: each electrode also reads its neighbours' signals.
  table->Add("electrodes leak", "%", {}, {5, 20, 60}, [](double s) {
    return Reads(OfEach([s, rest = std::make_shared<Rest>()](const Moment& moment, std::size_t f,
                                                             FingerReading& reading) {
      const FingerReading from = rest->Of(moment, f, reading), read = reading;
      const std::size_t n = read.channels.size();
      const auto away = [&](std::size_t e) { return read.channels[e] - from.channels[e]; };
      for (std::size_t e = 0; e < n; ++e) {
        const float leak = (away((e + 1) % n) + away((e + n - 1) % n)) / 2;
        reading.channels[e] += static_cast<float>(s / 100) * (leak - away(e));
      }
    }));
  });
  table->Add("noise in one finger", "times", {3}, {10}, [](double s) {
    return Reads(OfFirst([s](const Moment& moment, FingerReading& reading) {
      std::mt19937_64 random(moment.index);
      std::normal_distribution<double> normal(0, kNoise * std::sqrt(s * s - 1));
      for (float& e : reading.channels) e += static_cast<float>(normal(random));
    }));
  });
  table->Add("electrodes lag", "samples", {}, {2, 8}, [](double s) {
    using Lagged = std::map<std::size_t, FingerReading>;
    return Reads(OfEach([s, lagged = std::make_shared<Lagged>()](
                            const Moment& moment, std::size_t f, FingerReading& reading) {
      if (moment.index == 0) (*lagged)[f] = reading;
      FingerReading& was = (*lagged)[f];
      for (std::size_t e = 0; e < reading.channels.size(); ++e) {
        was.channels[e] += static_cast<float>((reading.channels[e] - was.channels[e]) / (1 + s));
        reading.channels[e] = was.channels[e];
      }
    }));
  });
  table->Rarely(false);
}

Alteration PoseOff(double metres, double degrees, When when) {
  return Reads(OfEach([=](const Moment& moment, std::size_t, FingerReading& reading) {
    if (!reading.X_SF || !IsSo(when, moment)) return;
    reading.X_SF->translation().z() += metres;
    reading.X_SF->rotate(
        Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Eigen::Vector3d::UnitY()));
  }));
}

void AddGeometry(CaseTable* table) {
  table->Add("pose wrong", "mm", {}, {2, 5},
             [](double s) { return PoseOff(1e-3 * s, 0, When::kAlways); });
  table->Add("pose turned", "deg", {}, {4, 10},
             [](double s) { return PoseOff(0, s, When::kAlways); });
  table->Add("object moved at rest", "mm", {}, {2, 5},
             [](double s) { return PoseOff(-1e-3 * s, 0, When::kAtRest); });
  table->Add("object elsewhere than stated", "mm", {}, {2, 5}, [](double s) {
    return AlterScene([s](Scene& scene) { scene.object.X_SO.translation().x() += 1e-3 * s; });
  });
  table->Add("object softer than stated", "times", {}, {2}, [](double s) {
    return AlterScene([s](Scene& scene) { scene.object.material.young_modulus *= s; });
  });
  // Another sensor reports other counts for the same force.
  table->Add("network of another sensor", "gain and order", {}, {1}, [](double) {
    return Reads(OfEach([rest = std::make_shared<Rest>()](const Moment& moment, std::size_t f,
                                                          FingerReading& reading) {
      const FingerReading from = rest->Of(moment, f, reading);
      const FingerReading read = reading;
      for (std::size_t e = 0; e < reading.channels.size(); ++e) {
        const std::size_t other = (e + 5) % reading.channels.size();
        const double gain = 0.6 + 0.05 * static_cast<double>(e);
        reading.channels[e] = static_cast<float>(
            from.channels[e] + gain * (read.channels[other] - from.channels[other]));
      }
    }));
  });
  table->Only("foam-cube-stiff");
  table->Add("beyond the force that was learnt", Demand::kFlag, {});
  table->Only({});
}

}  // namespace

std::vector<Case> FingertipCases() {
  CaseTable table;
  table.Add("undisturbed", Demand::kRight, {});
  AddElectrodes(&table);
  AddSamples(&table);
  AddGeometry(&table);
  AddUnseen(&table);
  AddUnseenToo(&table);
  return table.Take();
}

}  // namespace palpate::robustness
