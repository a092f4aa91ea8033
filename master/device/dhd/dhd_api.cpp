#include "master/device/dhd/dhd_api.h"

#include <utility>

namespace palpate {

LibrarySearch DhdSearch(std::vector<std::filesystem::path> folders) {
  LibrarySearch search{
      {"libdhd.so.3", "libdhd.so", "libdrd.so.3", "libdrd.so"}, std::move(folders), false};
#if defined(__aarch64__)
  constexpr const char* kTail = "lib/release/lin-aarch64-gcc";
#else
  constexpr const char* kTail = "lib/release/lin-x86_64-gcc";
#endif
  for (auto& folder : FolderOf("FORCEDIM_SDK", kTail)) search.folders.push_back(std::move(folder));
  search.folders.emplace_back("/usr/local/lib");
  return search;
}

std::string DhdApi::Load(const LibrarySearch& search) {
  SharedLibrary library(search);
  library.Bind("dhdGetDeviceCount", &device_count);
  library.Bind("dhdOpen", &open);
  library.Bind("dhdOpenSerial", &open_serial);
  library.Bind("dhdClose", &close);
  library.Bind("dhdStop", &stop);
  library.Bind("dhdGetSystemName", &system_name);
  library.Bind("dhdGetSDKVersion", &sdk_version);
  library.Bind("dhdErrorGetLastStr", &last_error_text);
  library.Bind("dhdErrorGetLast", &last_error);
  library.Bind("dhdHasWrist", &has_wrist);
  library.Bind("dhdHasActiveWrist", &has_active_wrist);
  library.Bind("dhdHasGripper", &has_gripper);
  library.Bind("dhdEnableForce", &enable_force);
  library.Bind("dhdGetPosition", &position);
  library.Bind("dhdGetLinearVelocity", &velocity);
  library.Bind("dhdGetOrientationFrame", &orientation);
  library.Bind("dhdGetGripperGap", &gripper_gap);
  library.Bind("dhdGetButtonMask", &buttons);
  library.Bind("dhdSetForce", &set_force);
  library.Bind("dhdSetForceAndTorque", &set_force_and_torque);
  library.Bind("dhdGetStatus", &status);
  library.BindOptional("dhdGetMaxForce", &max_force);
  library.BindOptional("dhdGetForce", &rendered_force);
  return library.problem();
}

}  // namespace palpate
