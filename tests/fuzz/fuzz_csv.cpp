// Every reader of CSV files.
#include <stdexcept>

#include "master/device/playback.h"
#include "shared/text/csv.h"
#include "slave/capture/tactile_recording.h"
#include "slave/scene/contour_file.h"
#include "slave/tactile/localise/electrode_layout.h"
#include "tests/fuzz/fuzz_files.h"

namespace palpate {
namespace {

void ReadTable(const std::filesystem::path& file) {
  CsvTable table(file, {{"case"}, {"x"}, {"y"}, {"width", false}});
  while (table.Next()) {
    const double sum = table.Number("x") + table.Number("y") + table.Number("width");
    if (table.Text("case").empty() || sum != sum) std::abort();
  }
}

void Read(std::size_t kind, const std::filesystem::path& file) {
  switch (kind) {
    case 0:
      return ReadTable(file);
    case 1:
      static_cast<void>(ReadTactileRecording(file, {}));
      return;
    case 2:
      static_cast<void>(ReadElectrodeLayout(file));
      return;
    case 3:
      static_cast<void>(ReadContourFile(file));
      return;
    default:
      Playback hand(file);
      for (int i = 0; i < 5; ++i) hand.Read(Time(std::chrono::milliseconds(100 * i)));
  }
}

}  // namespace
}  // namespace palpate

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace palpate;
  const fuzz::Input input(data, size, 5);
  const auto file = fuzz::Write("a.csv", input.bytes);
  // A contour without an area gives std::invalid_argument; the other errors name the file.
  fuzz::Try<std::invalid_argument>(
      [&] { fuzz::Try<std::runtime_error>([&] { Read(input.kind, file); }); });
  return 0;
}
