#include "master/commands/devices_command.h"

#include <cstdio>
#include <vector>

#include "master/device/registry/drivers.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

void Add(const char* what, const std::vector<std::string>& lines, std::string* text) {
  for (const std::string& line : lines) {
    *text += Formatted("    %-9s ", what) + Presentable(line, 1000) + "\n";
    what = "";
  }
}

}  // namespace

std::string InWords(const Driver& driver, const DriverReport& report) {
  const std::string name(driver.name);
  std::string text =
      Formatted("%-11s %s: %s\n", name.c_str(), report.usable ? "ready" : "not ready",
                std::string(driver.devices).c_str());
  Add("searched", report.searched, &text);
  Add("found", report.found, &text);
  Add("missing", report.missing, &text);
  const std::string use = "palpate-master connect HOST:PORT --device " + name +
                          "[:option], option: " + std::string(driver.option);
  Add("next", {report.next.empty() && report.usable ? use : report.next}, &text);
  return text;
}

int ListDevices() {
  for (const Driver& driver : Drivers()) {
    std::fputs(InWords(driver, driver.examine()).c_str(), stdout);
    std::fflush(stdout);
  }
  std::puts("sim-hand, playback:FILE.csv and pointer (with --view) need no device.");
  return 0;
}

}  // namespace palpate
