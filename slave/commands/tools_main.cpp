// palpate-tools: the commands of palpate-slave that no session needs. `palpate-slave COMMAND`
// executes this program with the command as its name.
#include <cstdio>
#include <string_view>

#include "slave/commands/program.h"
#include "slave/commands/tools.h"

namespace palpate {
namespace {

constexpr struct {
  std::string_view command;
  int (*main)(int argc, char** argv);
} kTools[] = {{"study", StudyMain},
              {"precompute", PrecomputeMain},
              {"identify", IdentifyMain},
              {"calibrate", CalibrateMain}};

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  const std::string_view command = argc > 0 ? argv[0] : "";
  for (const auto& tool : palpate::kTools) {
    if (tool.command == command) return tool.main(argc, argv);
  }
  std::fputs("palpate-tools: expected palpate-slave study, precompute, identify or calibrate\n",
             stderr);
  return palpate::kUnusable;
}
