#include "master/device/touch/hd_api.h"

#include <utility>

namespace palpate {

LibrarySearch HdSearch(std::vector<std::filesystem::path> folders) {
  LibrarySearch search{{"libHD.so", "libHD.so.3.4", "libHD.so.3"}, std::move(folders), true};
  for (const char* tail : {"lib", ""}) {
    for (auto& folder : FolderOf("GTDD_HOME", tail)) search.folders.push_back(std::move(folder));
  }
  return search;
}

std::string HdApi::Load(const LibrarySearch& search) {
  SharedLibrary library(search);
  library.Bind("hdInitDevice", &init_device);
  library.Bind("hdMakeCurrentDevice", &make_current);
  library.Bind("hdDisableDevice", &disable_device);
  library.Bind("hdBeginFrame", &begin_frame);
  library.Bind("hdEndFrame", &end_frame);
  library.Bind("hdGetError", &get_error);
  library.Bind("hdGetErrorString", &error_text);
  library.Bind("hdEnable", &enable);
  library.Bind("hdDisable", &disable);
  library.Bind("hdGetIntegerv", &get_integers);
  library.Bind("hdGetDoublev", &get_doubles);
  library.Bind("hdGetString", &get_text);
  library.Bind("hdSetDoublev", &set_doubles);
  library.Bind("hdCheckCalibration", &check_calibration);
  library.BindOptional("hdCheckCalibrationStyle", &calibration_style);
  library.Bind("hdUpdateCalibration", &update_calibration);
  library.Bind("hdStartScheduler", &start_scheduler);
  library.Bind("hdStopScheduler", &stop_scheduler);
  library.Bind("hdScheduleAsynchronous", &schedule);
  library.Bind("hdUnschedule", &unschedule);
  return library.problem();
}

}  // namespace palpate
